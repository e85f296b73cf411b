// The windows of a recording, tick by tick: its own events through the library's filter, its own motion
// through the library's ego-motion.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "core/inlets.hpp"
#include "hal/can_motion_decoder.hpp"
#include "hal/replay_source.hpp"
#include "pipeline/ego_motion.hpp"
#include "recording/folder.hpp"
#include "window_stack.hpp"

namespace egofocus::training {

/// Thread: one. Throws recording::Error.
class RecordingWindows {
 public:
  /// `folder.camera.config` is the configuration; change it before.
  explicit RecordingWindows(recording::Folder folder);

  /// Reads on to tick_us, which must rise, and stacks the window that ends there. False as
  /// WindowStack::run().
  bool tick(std::int64_t tick_us);

  [[nodiscard]] WindowStack& stack() noexcept { return stack_; }
  [[nodiscard]] const recording::Folder& folder() const noexcept { return folder_; }
  /// The motion of the last tick's longest window, as EgoMotion::samples() gives it.
  [[nodiscard]] std::vector<MotionSample> motion() const;
  /// Kept events of the last tick's longest window, in order, not decimated.
  [[nodiscard]] std::vector<Event> events() const;

 private:
  struct Rings {
    explicit Rings(const RingConfig& config);
    std::vector<Event> events;
    std::vector<ImuSample> imu;
    std::vector<OdometrySample> odometry;
    std::vector<PoseSample> poses;
    Inlets::Rings ends;
  };
  std::uint64_t drain(std::int64_t tick_us);
  void forget_before(std::int64_t t_us);

  recording::Folder folder_;
  std::unique_ptr<CanMotionDecoder> can_motion_;
  Rings rings_;
  std::unique_ptr<ReplaySource> source_;
  std::unique_ptr<EgoMotion> ego_motion_;  // large
  WindowStack stack_;
  std::deque<Event> kept_;  // of the longest window
  std::int64_t tick_us_ = INT64_MIN;
};

}  // namespace egofocus::training
