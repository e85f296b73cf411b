// Velocity, gravity, gyro bias and wheel scale from inertial samples and odometry: an error-state Kalman
// filter.
//
// All states live in the body frame, so no attitude is needed and every error is a plain vector:
//   v  velocity of the body origin                         v' = f - g - omega x v      (f: specific force,
//   accelerometer) g  specific force at rest: gravity, pointing up        g' = -omega x g b  gyro bias omega
//   = gyro - b,  b' = noise s  wheel scale error                                   wheel speed = (1 + s) v_x
// g is free in length as well: a constant accelerometer bias goes into it.
//
// What is missing:
//   no accelerometer   velocity follows the measurements; between them it wanders as kUnknownAccel says
//   no gyro            the rate is taken as zero with the uncertainty kUnknownRate; motion is then
//   translation only no odometry        nothing is known (ready() is false), however good the IMU kFree with
//   wheel speed only   sideways and vertical speed are not measured: the covariance says so
#pragma once

#include <cstdint>

#include "egofocus/config.hpp"
#include "egofocus/types.hpp"
#include "pipeline/eigen.hpp"
#include "pipeline/motion_track.hpp"

namespace egofocus {

/// Thread: one. RT: yes, O(1) per sample.
class VelocityFilter {
 public:
  static constexpr int kStates = 10;
  using Covariance = egofocus_eigen::Matrix<double, kStates, kStates>;

  /// Precondition: EgoMotion::check(config) is ok.
  explicit VelocityFilter(const MotionConfig& config) noexcept;

  /// Samples must come in order of time, finite and plausible.
  void use(const ImuSample& sample) noexcept;
  /// False: the innovation gate rejected it. After kLostAfter_us of nothing but rejections the velocity
  /// starts afresh.
  bool use(const OdometrySample& sample) noexcept;

  /// Velocity is known: there was an odometry sample, and no silence of kSilence_us since.
  [[nodiscard]] bool ready() const noexcept { return ready_; }
  /// At the newest sample, in the camera frame.
  [[nodiscard]] CameraMotion camera_motion() const noexcept;

  [[nodiscard]] const Vec3& velocity_m_s() const noexcept { return velocity_; }
  [[nodiscard]] const Vec3& gravity_m_s2() const noexcept { return gravity_; }
  [[nodiscard]] const Vec3& gyro_bias_rad_s() const noexcept { return bias_; }
  [[nodiscard]] double wheel_scale() const noexcept { return scale_; }
  [[nodiscard]] bool standing() const noexcept { return standing_; }
  /// Order: velocity, gravity, bias, scale.
  [[nodiscard]] const Covariance& covariance() const noexcept { return covariance_; }

 private:
  MotionConfig config_;
  Mat3 camera_from_body_;
  Vec3 lever_arm_;
  std::int64_t t_us_ = INT64_MIN;
  Vec3 velocity_ = Vec3::Zero();
  Vec3 gravity_ = Vec3::Zero();
  Vec3 bias_ = Vec3::Zero();
  double scale_ = 0;
  Covariance covariance_ = Covariance::Zero();
  Vec3 rate_ = Vec3::Zero();
  bool ready_ = false;
  bool standing_ = false;
};

}  // namespace egofocus
