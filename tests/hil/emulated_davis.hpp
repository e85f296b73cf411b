// A DAVIS346 as its documentation has it: parameters, start and stop, a stream in real time.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>

#include "hil/camera_time.hpp"
#include "hil/emulated_usb.hpp"
#include "hil/event_feed.hpp"

namespace egofocus::hil {

/// Streams while it runs: the feed's events; IMU samples at 1 kHz while its IMU runs; wraps. Short packets of
/// 1 ms; what nobody asks for waits, nothing is lost by the model itself. Source: libcaer, src/davis.c.
class EmulatedDavis : public EmulatedUsb {
 public:
  static constexpr int kWidth_px = 346;
  static constexpr int kHeight_px = 260;

  /// `feed` outlives the camera.
  explicit EmulatedDavis(EventFeed& feed);
  ~EmulatedDavis() override { unplug(); }

  /// Faults. Thread: any.
  void stall() { is_halted_ = true; }
  void hold(bool is_held) { is_held_ = is_held; }
  void set_logic_version(std::uint32_t version);
  void set_dropped(std::uint64_t events);
  [[nodiscard]] CameraTime& time() { return time_; }

 protected:
  bool control(const Setup& setup, Bytes& data) override;
  int in(std::uint8_t endpoint, std::size_t most, Bytes& data) override;
  void halt_cleared(std::uint8_t endpoint) override;

 private:
  void write(std::uint32_t address, std::uint32_t value);
  [[nodiscard]] bool runs(std::uint32_t address) const;
  void make_stream(std::int64_t until_us, std::size_t most, Bytes& data);
  void put_time(std::int64_t t_us, Bytes& data);

  EventFeed& feed_;
  mutable std::mutex mutex_;
  std::map<std::uint32_t, std::uint32_t> parameters_;
  CameraTime time_;
  bool has_reset_ = false;  // the mark is still to be sent
  std::int64_t wraps_sent_ = 0;
  std::int64_t next_imu_us_ = 0;
  std::atomic<bool> is_halted_{false};
  std::atomic<bool> is_held_{false};
};

}  // namespace egofocus::hil
