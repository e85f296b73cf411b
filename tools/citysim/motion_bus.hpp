// What a robot's motion sensors say on its CAN bus, with their faults; and how a reader must understand it.
//
//   kCar             Bosch MM7.10 IMU at 100 Hz (roll rate with the sign turned), wheel speeds of a Toyota
//   kDeliveryRobot   J1939 IMU at 100 Hz (x forward, y right, z down), wheel speeds in 1/16 km/h
//   kDrone           Xsens MTi at 100 Hz, big-endian, with its own velocity at 50 Hz in steps of 1/64 m/s
//   kHand            the same IMU; visual odometry at 30 Hz, mm/s
//   kArm             the same IMU; joint encoders' velocity at 100 Hz, mm/s
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "citysim/trajectory.hpp"
#include "egofocus/config.hpp"
#include "hal/can_frame.hpp"
#include "hal/can_motion_config.hpp"

namespace egofocus::citysim {

enum class BusRobot : std::uint8_t { kCar, kDeliveryRobot, kDrone, kHand, kArm };

/// Of one recording. Sensors sit at the body's origin and along its axes.
struct BusFaults {
  Vec3 gyro_bias_rad_s{0, 0, 0};     ///< at the start
  double gyro_bias_walk_rad_s2 = 0;  ///< per sqrt(s)
  double gyro_scale = 0;             ///< relative
  double gyro_noise_rad_s = 0;       ///< 1-sigma of a sample, each axis
  Vec3 accel_bias_m_s2{0, 0, 0};
  double accel_noise_m_s2 = 0;
  double odometry_scale = 0;           ///< relative, below 0.02
  double wheel_scale_spread = 0;       ///< relative, 1-sigma from wheel to wheel
  double odometry_noise_m_s = 0;       ///< of each wheel or component
  double odometry_zero_below_m_s = 0;  ///< wheels whose pulses stop
  std::int64_t imu_latency_us = 0;     ///< from the motion to the sensor's wish to send
  std::int64_t odometry_latency_us = 0;
  std::int64_t jitter_us = 0;  ///< added to each message's latency, 0 .. this
  double dropout_every_s = 0;  ///< mean time between two silences of the odometry; 0: none
  double lost_frame_share = 0;
};

/// Drawn per recording: a calibrated robot with what its calibration leaves over.
[[nodiscard]] BusFaults draw_bus_faults(BusRobot robot, std::uint64_t seed);

struct MotionBus {
  std::vector<CanFrame> frames;  ///< in order of time; candump_text() (can_bus.hpp) makes can.log of them
  std::string dbc;               ///< text of the DBC
  MotionConfig motion;           ///< [motion]: model, extrinsics, stated noises
  CanMotionConfig can;           ///< [can] and [[can.signals]]
  BusFaults faults;
  std::vector<std::pair<std::int64_t, std::int64_t>> dropouts_us;  ///< odometry was silent from .. to
  std::uint64_t motion_frames = 0;                                 ///< of `frames`, those with a role
  std::uint64_t lost_frames = 0;
  double load = 0;  ///< share of the time that the bus was in use
};

/// Time 0 is the trajectory's. Samples lie in [0, duration], frames come a latency later. Other traffic is on
/// the bus, too. `camera` goes into `motion` as the extrinsics. Throws std::invalid_argument for faults whose
/// latency or jitter is negative.
[[nodiscard]] MotionBus motion_bus(const Trajectory& trajectory, BusRobot robot, const BusFaults& faults,
                                   const Mount& camera, std::uint64_t seed);

}  // namespace egofocus::citysim
