// Does the robot stand? Only when every sensor that speaks has been quiet for a while.
#pragma once

#include <cstdint>

#include "egofocus/config.hpp"
#include "pipeline/eigen.hpp"

namespace egofocus {

/// Thread: one. RT: yes.
class Standstill {
 public:
  /// Quiet for so long.
  static constexpr std::int64_t kQuiet_us = 500000;
  /// Without odometry for so long nothing is known.
  static constexpr std::int64_t kSilence_us = 200000;

  explicit Standstill(const MotionConfig& config) noexcept;

  void see_gyro(const Vec3& rate_rad_s, std::int64_t t_us) noexcept;
  void see_accel(const Vec3& accel_m_s2, std::int64_t t_us) noexcept;
  void see_odometry(const Vec3& velocity_m_s, std::int64_t t_us) noexcept;

  [[nodiscard]] bool standing() const noexcept {
    return odometry_.quiet && newest_us_ - odometry_.t_us <= kSilence_us && gyro_.quiet && accel_.quiet;
  }

 private:
  /// Running mean and variance over about kMemory_s.
  struct Spread {
    Vec3 mean = Vec3::Zero();
    double variance = 0;  // sum over the axes
    std::int64_t t_us = INT64_MIN / 2;
    std::int64_t since_us = INT64_MIN / 2;  // quiet since
    bool quiet = false;

    void restart(const Vec3& value, std::int64_t at_us) noexcept;
    void add(const Vec3& value, std::int64_t at_us) noexcept;
    void judge(bool calm) noexcept;
  };

  double gyro_limit_;
  double accel_limit_;
  double speed_sigma_;
  std::int64_t newest_us_ = INT64_MIN / 2;
  Spread gyro_;
  Spread accel_;
  Spread odometry_;
};

}  // namespace egofocus
