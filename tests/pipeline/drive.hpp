// One simulated drive through EgoMotion: 200 Hz IMU, 50 Hz odometry, 20 Hz ticks.
#pragma once

#include <cstdint>

#include "pipeline/ego_motion.hpp"
#include "pipeline/robot_simulator.hpp"

namespace egofocus::test {

struct Drive {
  Path path;
  SensorFaults faults;
  std::uint64_t seed = 1;
  bool wheels = true;  ///< else body velocity
  bool gyro = true;
  bool accel = true;
  double duration_s = 38;
  double dropout_from_s = 1e9;  ///< odometry is silent for one second
};

/// Biases that a cheap sensor has: 1.4, 0.9 and 1.6 deg/s; 5 cm/s^2; wheels that read 2 % too much.
inline SensorFaults stated_faults() {
  SensorFaults faults;
  faults.gyro_bias_rad_s = {{0.025, -0.015, 0.028}};
  faults.accel_bias_m_s2 = {{0.05, -0.04, 0.06}};
  return faults;
}

inline Drive car_drive() {
  return {car_path(), stated_faults()};
}

inline Drive drone_drive() {
  Drive drive{drone_path(), stated_faults()};
  drive.wheels = false;
  return drive;
}

inline MotionConfig config_of(const Drive& drive) {
  MotionConfig config;
  config.model = drive.wheels ? MotionModel::kWheeled : MotionModel::kFree;
  return config;
}

/// `feed(sample)` gets each sample, `tick(robot)` is called every 50 ms.
template <typename Feed, typename Tick>
void simulate(const Drive& drive, Feed feed, Tick tick) {
  RobotSimulator robot(drive.path, drive.faults, drive.seed);
  const auto steps = static_cast<int>(drive.duration_s * 1000);
  for (int i = 1; i <= steps; ++i) {
    robot.step();
    if (i % 5 == 0) {
      ImuSample sample = robot.imu();
      sample.has_gyro = drive.gyro;
      sample.has_accel = drive.accel;
      feed(sample);
    }
    const bool silent = robot.t_s() >= drive.dropout_from_s && robot.t_s() < drive.dropout_from_s + 1;
    if (i % 20 == 7 && !silent) feed(drive.wheels ? robot.wheel() : robot.body_velocity());
    if (i % 50 == 0) tick(robot);
  }
}

}  // namespace egofocus::test
