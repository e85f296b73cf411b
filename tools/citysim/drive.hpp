// How wheeled robots move along a route: speed within limits, stops, turns, and a body that pitches, rolls
// and shakes on them.
#pragma once

#include <cstdint>

#include "citysim/drive_path.hpp"
#include "citysim/trajectory.hpp"
#include "citysim/ways.hpp"

namespace egofocus::citysim {

enum class Vehicle : std::uint8_t {
  kCar,            ///< 0..20 m/s, turns at up to 0.7 rad/s, stops at traffic lights
  kDeliveryRobot,  ///< 0..3 m/s on pavements, turns at up to 1.5 rad/s
  kCorridorRobot,  ///< 0..2 m/s on a flat floor, turns on the spot where it likes
};

struct DriveStyle {
  double max_speed_m_s = 20;
  double acceleration_m_s2 = 2.0;
  double braking_m_s2 = 2.5;
  double lateral_m_s2 = 2.5;  ///< in a turn
  double max_yaw_rate_rad_s = 0.7;
  double smoothing_s = 0.3;      ///< accelerations change within twice this time
  double stop_every_m = 160;     ///< mean way between two stops of 1-4 s; 0: none on the way
  double start_standing = 0.35;  ///< chance; else the recording begins at speed
  double hesitation = 0.35;      ///< a piece is driven at 1 - this .. 1 of its limit
  PathStyle path;
  double pitch_rad_per_m_s2 = 0.0045;  ///< nose down under braking
  double roll_rad_per_m_s2 = 0.008;    ///< outwards in a turn
  double sway_hz = 1.4;                ///< of the springs, lightly damped
  double slip_s2_per_m = 0.0008;       ///< slip angle at the rear axle, per lateral acceleration
  double heave_m_s = 0.02;             ///< rms of the vertical speed from the road, 1-15 Hz, at full speed
  double rock_rad_s = 0.02;            ///< rms of pitch and roll rate from the road, likewise
};

/// Drawn per recording: habits within what such a vehicle does, roads from smooth to rough.
[[nodiscard]] DriveStyle drive_style(Vehicle vehicle, std::uint64_t seed);

/// The body: x forward, y left, z up, its origin between the rear wheels on the ground, where wheels do not
/// let it move sideways (slip: below 1 % of the speed). It stays within the route's half width. At the end
/// of an open route it turns around, or stands for the rest if it cannot. Throws std::invalid_argument for a
/// route that cannot be driven (drive_path.hpp) or a duration outside (0, 1000] s.
[[nodiscard]] Trajectory drive(const Ways& ways, const DriveStyle& style, double duration_s,
                               std::uint64_t seed);

}  // namespace egofocus::citysim
