// A robot of scripted devices around the real sources and the real engine: a DAVIS on a scripted USB bus, an
// IMU and a wheel on a scripted CAN bus. It drives past a dotted wall that is exactly 1 m to its left, so
// that the true depth of every pixel is known at all times. Simulated time; no thread.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "hal/can_motion_decoder.hpp"
#include "hal/scripted_can.hpp"
#include "hal/socketcan_source.hpp"
#include "hal/usb_cameras.hpp"
#include "inivation_writer.hpp"
#include "support/engine_in_block.hpp"
#include "support/sliding_scene.hpp"

namespace egofocus::reliability {

/// What can be wrong while it lasts. Everything else is done to `bus` and `kernel` themselves.
struct Trouble {
  bool camera_silent = false;
  int event_copies = 1;            // each event so many times over
  int hot_pixels = 0;              // each fires at kHotPixel_hz
  double drift_ppm = 0;            // of the camera's clock
  std::int64_t jitter_us = 0;      // of the camera's transfers, at most
  double corrupt_words = 0;        // share of words that become random ones
  double short_transfers = 0;      // share that ends in the middle of a word
  double stalled_transfers = 0;    // share that ends with a stall
  double overflown_transfers = 0;  // share that is lost by an overflow
  bool can_silent = false;
  bool imu_silent = false;
  bool wheel_silent = false;
  bool wheel_stuck = false;  // says what it said before
  double accel_m_s2 = 0;     // the robot's, along its way
};

/// Frames since the last look.
struct Seen {
  int ticks = 0;
  int good = 0;
  std::uint32_t flags = 0;          // of all
  int poor_unflagged = 0;           // frames without a flag that were not good
  double worst_unflagged = 0;       // their worst median relative error
  std::int64_t not_good_us = 0;     // time of the newest one that was not good; 0: all were
  std::int64_t clock_error_us = 0;  // largest of an event's time against the true one
};

class Robot {
 public:
  static constexpr std::int64_t kStep_us = 5'000;
  static constexpr int kHotPixel_hz = 2'000;
  /// A median relative error of depth up to this, without any flag, is good.
  static constexpr double kGood = 0.1;

  static Config engine_config();
  explicit Robot(const Config& config = engine_config(), const SocketCanConfig& can = {});
  ~Robot();

  /// On for so long, in steps of kStep_us.
  void run(std::int64_t us);
  /// Frames since the last call.
  Seen look();
  /// Everything that is counted, by the names that the daemon gives them.
  [[nodiscard]] std::map<std::string, std::uint64_t> counters() const;

  [[nodiscard]] std::int64_t now_us() const noexcept { return now_us_; }
  [[nodiscard]] const scripted::Camera& camera() const noexcept { return bus.cameras[0]; }
  scripted::Camera& camera() noexcept { return bus.cameras[0]; }
  [[nodiscard]] UsbCameraPhase phase() const noexcept { return usb_->counters().phase; }
  /// The camera's clock leaps, without a word about it.
  void leap_camera_clock(std::int64_t us) noexcept { clock_leap_us_ += us; }
  /// The camera begins its clock anew, and says so.
  void reset_camera_clock();
  void set_speed(double m_s) noexcept { speed_m_s_ = m_s; }

  Trouble trouble;
  scripted::Usb bus;
  test::ScriptedCan kernel;
  /// Events that the camera put into transfers which came to the host whole.
  std::uint64_t events_sent = 0;
  std::uint64_t events_sent_at_tick = 0;  // when the engine last told its counters
  /// Events of the world while no transfer could take them.
  std::uint64_t events_unseen = 0;

 private:
  void poll_camera(std::int64_t until_us);
  void begin_camera_clock(std::int64_t t_us);
  void film(std::int64_t until_us);
  void send(inivation::Bytes& bytes, std::uint64_t events);
  void speak(std::int64_t from_us, std::int64_t to_us);
  void tick();
  void judge(const DepthFrame& frame);
  void compare_times(std::span<const Event> events) noexcept;
  [[nodiscard]] std::int64_t device_us(std::int64_t t_us) const noexcept;
  bool chance(double share) { return std::uniform_real_distribution<>(0, 1)(random_) < share; }

  test::SlidingScene scene_;
  std::mt19937 random_{20};
  std::int64_t now_us_ = 1'000'000;
  std::int64_t filmed_us_ = now_us_;
  double scene_us_ = 0;  // how far the scene has gone: it knows one speed alone
  double speed_m_s_ = test::SlidingScene::kSpeed_m_s;
  double wheel_says_m_s_ = speed_m_s_;

  InivationWriter writer_{InivationWriter::Camera::kDavis};
  std::int64_t clock_begun_us_ = 0;
  std::int64_t clock_leap_us_ = 0;
  double drifted_us_ = 0;
  bool was_streaming_ = false;
  std::deque<std::int64_t> true_times_us_;  // of events on their way to the tap

  std::unique_ptr<CanMotionDecoder> motion_;
  std::vector<std::byte> buffers_;
  UsbIo usb_io_;
  std::unique_ptr<UsbCameraSource> usb_;
  std::unique_ptr<SocketCanSource> can_;
  mutable test::EngineInBlock engine_;
  Seen seen_;
};

}  // namespace egofocus::reliability
