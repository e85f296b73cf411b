// The wire formats of motion_bus: packing by hand, and the DBC and roles that a reader needs.
#pragma once

#include <string>
#include <vector>

#include "citysim/motion_bus.hpp"

namespace egofocus::citysim {

/// One sample of each sensor in the sensor's own axes, SI.
struct ImuReading {
  std::int64_t t_us = 0;
  Vec3 rate_rad_s{0, 0, 0};
  Vec3 force_m_s2{0, 0, 0};
};
struct WheelReading {
  double front_left_m_s = 0;
  double front_right_m_s = 0;
  double rear_left_m_s = 0;
  double rear_right_m_s = 0;
};

/// A message that has nothing to do with motion; its bytes are random.
struct OtherMessage {
  std::uint32_t id = 0;
  bool extended = false;
  int length = 8;
  std::int64_t period_us = 0;
};

struct BusLayout {
  int bits_per_s = 500000;
  std::int64_t imu_period_us = 10000;
  std::int64_t odometry_period_us = 20000;
  std::size_t gyro_frame = 0;  ///< of an IMU sample's frames, the first with a rate: a reader stamps that one
  bool wheels = false;
  double track_m = 0;
  double wheelbase_m = 0;
  std::string dbc;
  CanMotionConfig can;  ///< without delays
  MotionConfig motion;  ///< without extrinsics
  std::vector<OtherMessage> others;
};

[[nodiscard]] BusLayout bus_layout(BusRobot robot);

/// The frames of one sample, in the order in which the sensor sends them, without times. `count` numbers the
/// samples from 0.
[[nodiscard]] std::vector<CanFrame> imu_frames(BusRobot robot, const ImuReading& reading,
                                               std::uint32_t count);
[[nodiscard]] CanFrame wheel_frame(BusRobot robot, const WheelReading& reading);
[[nodiscard]] CanFrame velocity_frame(BusRobot robot, const Vec3& velocity_m_s, std::uint32_t count);

}  // namespace egofocus::citysim
