#include "hal/can_motion_config.hpp"

namespace egofocus {
namespace {

constexpr const char* kRoleNames[kCanRoles] = {
    "gyro_x",      "gyro_y",      "gyro_z",      "accel_x",     "accel_y",     "accel_z",
    "wheel_speed", "velocity_x",  "velocity_y",  "velocity_z",  "variance_xx", "variance_xy",
    "variance_xz", "variance_yy", "variance_yz", "variance_zz", "counter",
};

struct UnitName {
  const char* name;
  CanUnit unit;
};
constexpr UnitName kUnitNames[] = {
    {"si", CanUnit::kSi},          {"rad/s", CanUnit::kSi},           {"m/s^2", CanUnit::kSi},
    {"m/s", CanUnit::kSi},         {"deg/s", CanUnit::kDegPerSecond}, {"g", CanUnit::kStandardGravity},
    {"km/h", CanUnit::kKmPerHour},
};

}  // namespace

std::int64_t can_lag_us(const CanMotionConfig& config) noexcept {
  const std::int64_t delay =
      config.imu_delay_us > config.odometry_delay_us ? config.imu_delay_us : config.odometry_delay_us;
  return config.group_window_us + (delay > 0 ? delay : 0);
}

const char* to_string(CanRole role) noexcept {
  const auto index = static_cast<std::size_t>(role);
  return index < kCanRoles ? kRoleNames[index] : "unknown";
}

bool can_role_of(std::string_view name, CanRole& role) noexcept {
  for (std::size_t i = 0; i < kCanRoles; ++i) {
    if (name != kRoleNames[i]) continue;
    role = static_cast<CanRole>(i);
    return true;
  }
  return false;
}

bool can_unit_of(std::string_view name, CanUnit& unit) noexcept {
  for (const UnitName& known : kUnitNames) {
    if (name != known.name) continue;
    unit = known.unit;
    return true;
  }
  return false;
}

}  // namespace egofocus
