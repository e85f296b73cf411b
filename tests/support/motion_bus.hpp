// What an IMU and a body-velocity sensor on a CAN bus say about a trajectory, as a candump log and its DBC.
// The frames are packed by hand here, so that the library's DBC code is checked against something else.
#pragma once

#include <cstdint>
#include <string>

#include "egofocus/config.hpp"
#include "support/trajectory.hpp"

namespace egofocus::sim {

struct MotionFaults {
  Vec3 gyro_bias_rad_s{0.004, -0.006, 0.005};
  double gyro_noise_rad_s = 0.003;
  Vec3 accel_bias_m_s2{0.03, -0.02, 0.04};
  double accel_noise_m_s2 = 0.05;
  double velocity_noise_m_s = 0.004;
};

/// Velocity and rate of the body origin in the body frame, seen through the extrinsics (lever arm included).
struct BodyTwist {
  Vec3 velocity_m_s;
  Vec3 rate_rad_s;
};
BodyTwist body_twist(const Twist& camera, const MotionConfig& extrinsics);

/// The DBC: gyro (11-bit id, Intel), accelerometer (11-bit id, Motorola), body velocity (29-bit id,
/// multiplexed).
std::string vehicle_dbc();

/// IMU at 200 Hz, body velocity at 50 Hz. World z is up.
std::string can_log(const Trajectory& trajectory, const MotionConfig& extrinsics, const MotionFaults& faults,
                    std::uint64_t seed);

}  // namespace egofocus::sim
