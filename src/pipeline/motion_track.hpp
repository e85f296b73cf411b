// How the camera moved during one window: what the warp needs (MotionTrack), what that rests on
// (MotionSample) and what its user may ask (CameraMotion). METHOD: a static point has dP/dt = -omega x P - T
// in camera coordinates; R and c of the track follow from it.
#pragma once

#include <cstdint>
#include <span>

namespace egofocus {

/// Takes a static point from camera coordinates at the knot's time to those at the track's end:
/// P_end = rotation * P + centre_m. `rotation` is row-major; `centre_m` is the camera's centre, seen at the
/// end.
struct MotionKnot {
  double rotation[9];
  double centre_m[3];
};

/// Knots uniform in time: knot i is at begin_us + i * (end_us - begin_us) / (kKnots - 1); the last is the
/// identity. Between two knots R and c are interpolated linearly (error below 0.001 px at f = 335 px and 0.3
/// rad in the window).
struct MotionTrack {
  static constexpr int kKnots = 128;
  std::int64_t begin_us = 0;
  std::int64_t end_us = 0;
  MotionKnot knots[kKnots];
};

/// Velocity of the camera's centre and angular rate, both in the camera frame (x right, y down, z forward).
struct MotionSample {
  std::int64_t t_us = 0;
  double velocity_m_s[3] = {0, 0, 0};
  double angular_rate_rad_s[3] = {0, 0, 0};
};

/// And how well it is known.
struct CameraMotion : MotionSample {
  /// Upper triangles xx, xy, xz, yy, yz, zz, 1-sigma squared. All zero: not known (motion from poses, and
  /// motion before the newest sample).
  double velocity_covariance_m2_s2[6] = {0, 0, 0, 0, 0, 0};
  double rate_covariance_rad2_s2[6] = {0, 0, 0, 0, 0, 0};
};

/// The track of piecewise linear velocity and angular rate through `motion`: at least one, times rising. Held
/// constant before the first and beyond the last. Fourth order: errors are below 1e-9 m and rad for 1 rad and
/// 3 m in a window. Thread: any. RT: yes, O(kKnots + motion.size()).
void integrate_track(std::span<const MotionSample> motion, std::int64_t begin_us, std::int64_t end_us,
                     MotionTrack& out) noexcept;

/// 1-sigma of |velocity|, along the velocity itself; of its largest component where the velocity is zero.
/// Thread: any. RT: yes.
double speed_sigma_m_s(const CameraMotion& motion) noexcept;

}  // namespace egofocus
