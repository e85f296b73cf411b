// The last poses of the camera in its world: constant velocity and constant angular rate between two of them,
// and beyond the last two.
#pragma once

#include <cstdint>

#include "egofocus/config.hpp"
#include "egofocus/types.hpp"
#include "pipeline/motion_track.hpp"
#include "pipeline/rotation.hpp"

namespace egofocus {

/// Thread: one. RT: yes.
class PoseHistory {
 public:
  static constexpr std::uint32_t kCapacity = 1024;

  explicit PoseHistory(const MotionConfig& config) noexcept;

  /// Times must rise. False: the step from the last pose is faster than a robot can move. The pose is kept,
  /// but no track is built across the step.
  bool add(const PoseSample& pose) noexcept;

  /// With fewer than two poses nothing is known: INT64_MAX and INT64_MIN.
  [[nodiscard]] std::int64_t earliest_us() const noexcept;
  [[nodiscard]] std::int64_t newest_us() const noexcept;

  /// No gap and no jump between the poses that the window rests on. Precondition: earliest_us() <= begin_us
  /// <= end_us.
  [[nodiscard]] bool whole(std::int64_t begin_us, std::int64_t end_us) const noexcept;
  /// Velocity and rate of the segment that t_us lies in. Precondition: two poses.
  [[nodiscard]] CameraMotion at(std::int64_t t_us) const noexcept;
  void track(std::int64_t begin_us, std::int64_t end_us, MotionTrack& out) const noexcept;

 private:
  struct Pose {
    std::int64_t t_us = 0;
    Vec3 position_m = Vec3::Zero();
    Quaternion orientation;
    // The step from the predecessor to this pose.
    Vec3 velocity_m_s = Vec3::Zero();  // in the world
    Vec3 rate_rad_s = Vec3::Zero();    // in the camera
    bool joined = false;               // no gap, no jump
  };
  struct Placed {
    Vec3 position_m;
    Quaternion orientation;
  };

  [[nodiscard]] const Pose& pose(std::uint32_t i) const noexcept {
    return poses_[(first_ + i) & (kCapacity - 1)];
  }
  /// Index of the later pose of the step that t_us lies in: 1 <= index < size_.
  [[nodiscard]] std::uint32_t step_of(std::int64_t t_us) const noexcept;
  /// `t_s` is seconds after the step's earlier pose.
  [[nodiscard]] Placed place(std::uint32_t step, double t_s) const noexcept;

  Pose poses_[kCapacity];
  std::uint32_t first_ = 0;
  std::uint32_t size_ = 0;
  std::int64_t max_gap_us_;
  double max_speed_m_s_;
  double max_rate_rad_s_;
};

}  // namespace egofocus
