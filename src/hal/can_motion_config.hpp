// Which CAN signal means which motion, and how the sensor's axes lie in the body.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "hal/axis_map.hpp"
#include "hal/dbc.hpp"

namespace egofocus {

enum class CanRole : std::uint8_t {
  kGyroX,
  kGyroY,
  kGyroZ,
  kAccelX,
  kAccelY,
  kAccelZ,
  kWheelSpeed,  ///< may be given several times: the mean counts
  kVelocityX,
  kVelocityY,
  kVelocityZ,
  kVarianceXx,  ///< covariance of the body velocity, (m/s)^2
  kVarianceXy,
  kVarianceXz,
  kVarianceYy,
  kVarianceYz,
  kVarianceZz,
  kCounter,  ///< equal in all frames of one sample; one per message, where a sensor has it
};
inline constexpr std::size_t kCanRoles = 17;

/// What the signal's physical value is in. kSi: rad/s, m/s^2, m/s, (m/s)^2, as the role says.
enum class CanUnit : std::uint8_t { kSi, kDegPerSecond, kStandardGravity, kKmPerHour };

/// Value in SI = (physical value of the DBC * scale + offset) * unit. A sign is a scale of -1.
struct CanSignalRole {
  char message[kMaxDbcName + 1] = {};
  char signal[kMaxDbcName + 1] = {};
  CanRole role = CanRole::kGyroX;
  CanUnit unit = CanUnit::kSi;
  double scale = 1;
  double offset = 0;
  /// Raw values above it say "not available" or "error" (J1939: 0xFAFF); the sample is dropped and counted.
  std::uint64_t raw_max = UINT64_MAX;
};

struct CanMotionConfig {
  static constexpr std::size_t kMaxSignals = 32;
  CanSignalRole signals[kMaxSignals];
  std::size_t signal_count = 0;
  AxisMap gyro_axes;
  AxisMap accel_axes;
  /// The frames of one sample lie at most this far apart; choose half the sample period or less.
  std::int64_t group_window_us = 5000;
  bool stamp_last_frame = false;  ///< a sample's time is that of its first frame, or of its last
  std::int64_t imu_delay_us = 0;  ///< from the motion to the frame; subtracted
  std::int64_t odometry_delay_us = 0;
  /// All 29-bit ids match by their J1939 parameter group alone: any priority, source and destination address.
  /// A DBC may say so of its messages itself: DbcMessage::parameter_group.
  bool match_parameter_group = false;
};

/// How much older than the frame that completes it a motion sample can be: group window plus the longest
/// delay. Thread: any. RT: yes.
std::int64_t can_lag_us(const CanMotionConfig& config) noexcept;

/// The name that configurations use: "gyro_x", "wheel_speed", "variance_xx", "counter".
/// Thread: any. RT: yes.
const char* to_string(CanRole role) noexcept;
/// False if there is no role of that name.
/// Thread: any. RT: yes.
bool can_role_of(std::string_view name, CanRole& role) noexcept;

/// "si", "rad/s", "m/s^2", "m/s", "deg/s", "g", "km/h". False if there is no such unit.
/// Thread: any. RT: yes.
bool can_unit_of(std::string_view name, CanUnit& unit) noexcept;

}  // namespace egofocus
