#include "pipeline/velocity_filter.hpp"

#include "pipeline/rotation.hpp"

namespace egofocus {

VelocityFilter::VelocityFilter(const MotionConfig& config) noexcept : config_(config) {
  const double* const r = config.camera_from_body;
  camera_from_body_ << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
  const double* const l = config.camera_in_body_m;
  lever_arm_ = Vec3(l[0], l[1], l[2]);
}

void VelocityFilter::use(const ImuSample& sample) noexcept {
  t_us_ = sample.t_us;
  if (sample.has_gyro) rate_ = Vec3(sample.gyro_rad_s[0], sample.gyro_rad_s[1], sample.gyro_rad_s[2]);
}

bool VelocityFilter::use(const OdometrySample& sample) noexcept {
  t_us_ = sample.t_us;
  const bool forward_only = sample.kind == OdometrySample::Kind::kWheelSpeed;
  velocity_ = Vec3(sample.velocity_m_s[0], forward_only ? 0 : sample.velocity_m_s[1],
                   forward_only ? 0 : sample.velocity_m_s[2]);
  ready_ = true;
  return true;
}

CameraMotion VelocityFilter::camera_motion() const noexcept {
  const Vec3 velocity = camera_from_body_ * (velocity_ + cross(rate_, lever_arm_));
  const Vec3 rate = camera_from_body_ * rate_;
  CameraMotion motion;
  motion.t_us = t_us_;
  for (int i = 0; i < 3; ++i) {
    motion.velocity_m_s[i] = velocity[i];
    motion.angular_rate_rad_s[i] = rate[i];
  }
  return motion;
}

}  // namespace egofocus
