// Velocity, gravity, sensor biases and wheel scale from inertial samples and odometry: an error-state Kalman
// filter.
//
// All states live in the body frame, so no attitude is needed and every error is a plain vector:
//   v  velocity of the body origin                   v' = f - g - omega x v      (f: specific force,
//   accelerometer) g  specific force at rest: gravity, pointing up  g' = -omega x g b  gyro bias omega = gyro
//   - b, b' = noise s  wheel scale error                             wheel speed = (1 + s) v_x
// A robot that never tilts cannot tell a from g; their sum is what counts, and the covariance knows.
//
// Measurements: wheel speed (v_x and s) or body velocity (v); kWheeled: v_y = v_z = 0 at kLateralEvery_us;
// and at standstill, when gyro, accelerometer and odometry are all quiet: v = 0 and gyro = b. (A turn that is
// slow, perfectly even and on the spot looks like a bias until the bias is known; afterwards the gate refuses
// it.)
//
// A wheel speed of exactly zero means that no pulses come: slower than 1..2 km/h, no more. It is weighed so,
// but it still counts as quiet for the standstill.
//
// The yaw bias of a kWheeled robot shows at standstill and when speed changes; at a constant speed it looks
// like a roll (b_z v = g_y), and the covariance says so.
//
// What may be missing:
//   no accelerometer   velocity keeps its direction in the body and wanders as kUnknownAccel says
//   no gyro            the rate is zero, with the uncertainty kUnknownRate: motion is translation only
//   no odometry        nothing is known (ready() is false), however good the IMU
//   kFree with wheel speed only   sideways and vertical speed are not measured: the covariance says so
#pragma once

#include <cstdint>

#include "egofocus/config.hpp"
#include "egofocus/types.hpp"
#include "pipeline/covariance.hpp"
#include "pipeline/eigen.hpp"
#include "pipeline/motion_track.hpp"
#include "pipeline/standstill.hpp"

namespace egofocus {

/// Thread: one. RT: yes, O(1) per sample.
class VelocityFilter {
 public:
  /// First state of each part.
  static constexpr int kVelocity = 0;
  static constexpr int kGravity = 3;
  static constexpr int kGyroBias = 6;
  static constexpr int kAccelBias = 9;
  static constexpr int kScale = 12;

  static constexpr std::int64_t kHold_us = 100000;  ///< a gyro or accelerometer silent for longer is missing
  static constexpr std::int64_t kRestart_us =
      500000;  ///< no sample at all for longer: velocity starts afresh
  static constexpr std::int64_t kSilence_us =
      3000000;                                       ///< no odometry for longer: velocity is no longer known
  static constexpr std::int64_t kLost_us = 1000000;  ///< odometry rejected for longer: velocity starts afresh
  static constexpr std::int64_t kDoubt_us = 2000000;
  static constexpr double kStrainFor_s = 0.2;
  static constexpr double kMostStrain = 2;

  /// Precondition: EgoMotion::check(config) is ok.
  explicit VelocityFilter(const MotionConfig& config) noexcept;

  /// Samples must come in order of time, finite and plausible.
  void use(const ImuSample& sample) noexcept;
  /// False: the innovation gate rejected it.
  bool use(const OdometrySample& sample) noexcept;

  /// Velocity is known.
  [[nodiscard]] bool ready() const noexcept { return ready_; }
  /// The gyro speaks.
  [[nodiscard]] bool has_gyro() const noexcept { return t_us_ - gyro_.t_us <= kHold_us; }
  /// Something that spoke before contradicts the rest, or has been silent, for longer than `limit_us` at
  /// `t_us`: the gyro is silent; odometry is rejected; or odometry has not agreed with the rest for
  /// kDoubt_us. It disagrees when velocity had to start afresh from what was rejected before, and when its
  /// innovations lean to one side: kMostStrain standard deviations on average over kStrainFor_s.
  [[nodiscard]] bool doubts(std::int64_t t_us, std::int64_t limit_us) const noexcept;
  /// At the newest sample, in the camera frame.
  [[nodiscard]] CameraMotion camera_motion() const noexcept;

  [[nodiscard]] const Vec3& velocity_m_s() const noexcept { return velocity_; }
  [[nodiscard]] const Vec3& gravity_m_s2() const noexcept { return gravity_; }
  [[nodiscard]] const Vec3& gyro_bias_rad_s() const noexcept { return gyro_bias_; }
  [[nodiscard]] double wheel_scale() const noexcept { return scale_; }
  [[nodiscard]] bool standing() const noexcept { return standstill_.standing(); }
  [[nodiscard]] const Covariance& covariance() const noexcept { return covariance_; }

 private:
  /// The last sample of one sensor.
  struct Reading {
    Vec3 value = Vec3::Zero();
    std::int64_t t_us = INT64_MIN / 2;
    double period_s = 0;
  };
  enum class Outlier { kReject, kWeaken };

  [[nodiscard]] bool has_accel() const noexcept { return t_us_ - accel_.t_us <= kHold_us; }
  static Vec3 renew(Reading& reading, const double (&value)[3], std::int64_t t_us) noexcept;
  void move_to(std::int64_t t_us, const Vec3& gyro, const Vec3& accel) noexcept;
  void start_gravity() noexcept;
  void start_velocity(const OdometrySample& sample) noexcept;
  void forget_odometry() noexcept;
  void notice_strain(std::int64_t since_us) noexcept;
  bool measure_wheel(const OdometrySample& sample) noexcept;
  bool measure_body(const OdometrySample& sample) noexcept;
  void notice_departure() noexcept;
  void measure_standstill() noexcept;
  [[nodiscard]] bool fits(int component, const Row& h, double residual, double variance) noexcept;
  void update(const Row& h, double residual, double variance) noexcept;
  void correct(int state, double value, double sigma, Outlier outlier) noexcept;

  MotionConfig config_;
  Mat3 camera_from_body_;
  Vec3 lever_arm_;
  Standstill standstill_;
  bool stood_ = false;

  std::int64_t t_us_ = INT64_MIN / 2;
  Reading gyro_;
  Reading accel_;
  std::int64_t odometry_us_ = INT64_MIN / 2;
  std::int64_t accepted_us_ = INT64_MIN / 2;
  std::int64_t doubt_until_us_ = INT64_MIN / 2;
  double innovation_[3] = {0, 0, 0};  // of the newest odometry, in standard deviations
  double strain_[3] = {0, 0, 0};      // their mean
  std::int64_t lateral_us_ = INT64_MIN / 2;
  bool ready_ = false;
  bool gravity_known_ = false;

  Vec3 velocity_ = Vec3::Zero();
  Vec3 gravity_ = Vec3::Zero();
  Vec3 gyro_bias_ = Vec3::Zero();
  Vec3 accel_bias_ = Vec3::Zero();
  double scale_ = 0;
  Covariance covariance_ = Covariance::Zero();  // in the order of the k... constants above
};

}  // namespace egofocus
