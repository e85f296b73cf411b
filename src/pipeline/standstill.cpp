#include "pipeline/standstill.hpp"

namespace egofocus {
namespace {

constexpr double kMemory_s = 0.25;
constexpr std::int64_t kGap_us = 100000;  // a sensor silent for longer starts again

/// Twice the stated noise on each of three axes.
double spread_limit(double sigma) noexcept {
  return 3 * (2 * sigma) * (2 * sigma);
}

}  // namespace

Standstill::Standstill(const MotionConfig& config) noexcept
    : gyro_limit_(spread_limit(config.gyro_noise_rad_s)),
      accel_limit_(spread_limit(config.accel_noise_m_s2)),
      speed_sigma_(config.wheel_noise_m_s) {
  // A sensor that never speaks is not asked.
  gyro_.quiet = true;
  accel_.quiet = true;
}

void Standstill::Spread::restart(const Vec3& value, std::int64_t at_us) noexcept {
  mean = value;
  variance = 0;
  t_us = at_us;
  since_us = at_us;
}

void Standstill::Spread::add(const Vec3& value, std::int64_t at_us) noexcept {
  const double dt_s = static_cast<double>(at_us - t_us) * 1e-6;
  const double share = dt_s / (dt_s + kMemory_s);
  const Vec3 off = value - mean;
  mean += off * share;
  variance += (off.squaredNorm() - variance) * share;
  t_us = at_us;
}

void Standstill::Spread::judge(bool calm) noexcept {
  if (!calm) since_us = t_us;
  quiet = t_us - since_us >= kQuiet_us;
}

void Standstill::see_gyro(const Vec3& rate_rad_s, std::int64_t t_us) noexcept {
  if (t_us - gyro_.t_us > kGap_us) gyro_.restart(rate_rad_s, t_us);
  gyro_.add(rate_rad_s, t_us);
  gyro_.judge(gyro_.variance <= gyro_limit_);
  newest_us_ = t_us;
}

void Standstill::see_accel(const Vec3& accel_m_s2, std::int64_t t_us) noexcept {
  if (t_us - accel_.t_us > kGap_us) accel_.restart(accel_m_s2, t_us);
  accel_.add(accel_m_s2, t_us);
  accel_.judge(accel_.variance <= accel_limit_);
  newest_us_ = t_us;
}

void Standstill::see_odometry(const Vec3& velocity_m_s, std::int64_t t_us) noexcept {
  const bool moving = velocity_m_s.squaredNorm() > 9 * speed_sigma_ * speed_sigma_;
  if (moving || t_us - odometry_.t_us > kSilence_us) odometry_.restart(velocity_m_s, t_us);
  odometry_.add(velocity_m_s, t_us);
  odometry_.judge(odometry_.mean.squaredNorm() <= 0.25 * speed_sigma_ * speed_sigma_);
  newest_us_ = t_us;
}

}  // namespace egofocus
