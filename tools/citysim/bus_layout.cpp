#include "citysim/bus_layout.hpp"

#include <cstring>
#include <initializer_list>
#include <stdexcept>

namespace egofocus::citysim {
namespace {

constexpr const char* kCarDbc = R"(VERSION ""

NS_ :

BS_:

BU_: IMU ABS ECU

BO_ 372 MM_TX1: 8 IMU
 SG_ YawRate : 0|16@1+ (0.005,-163.84) [-163.84|163.835] "deg/s" ECU
 SG_ YawRateStatus : 20|4@1+ (1,0) [0|15] "" ECU
 SG_ AccelY : 32|16@1+ (0.000127465,-4.1768) [-4.1768|4.1767] "g" ECU
 SG_ Counter1 : 48|4@1+ (1,0) [0|15] "" ECU
 SG_ AccelYStatus : 52|4@1+ (1,0) [0|15] "" ECU

BO_ 376 MM_TX2: 8 IMU
 SG_ RollRate : 0|16@1+ (0.005,-163.84) [-163.84|163.835] "deg/s" ECU
 SG_ RollRateStatus : 20|4@1+ (1,0) [0|15] "" ECU
 SG_ AccelX : 32|16@1+ (0.000127465,-4.1768) [-4.1768|4.1767] "g" ECU
 SG_ Counter2 : 48|4@1+ (1,0) [0|15] "" ECU
 SG_ AccelXStatus : 52|4@1+ (1,0) [0|15] "" ECU

BO_ 380 MM_TX3: 8 IMU
 SG_ PitchRate : 0|16@1+ (0.005,-163.84) [-163.84|163.835] "deg/s" ECU
 SG_ PitchRateStatus : 20|4@1+ (1,0) [0|15] "" ECU
 SG_ AccelZ : 32|16@1+ (0.000127465,-4.1768) [-4.1768|4.1767] "g" ECU
 SG_ Counter3 : 48|4@1+ (1,0) [0|15] "" ECU
 SG_ AccelZStatus : 52|4@1+ (1,0) [0|15] "" ECU

BO_ 170 WHEEL_SPEEDS: 8 ABS
 SG_ WheelSpeedFR : 7|16@0+ (0.01,-67.67) [0|250] "km/h" ECU
 SG_ WheelSpeedFL : 23|16@0+ (0.01,-67.67) [0|250] "km/h" ECU
 SG_ WheelSpeedRR : 39|16@0+ (0.01,-67.67) [0|250] "km/h" ECU
 SG_ WheelSpeedRL : 55|16@0+ (0.01,-67.67) [0|250] "km/h" ECU

CM_ BO_ 372 "The sensor sends its roll rate with the sign turned: see camera.toml.";
)";

constexpr const char* kDeliveryDbc = R"(VERSION ""

NS_ :

BS_:

BU_: IMU DRIVE ECU

BO_ 2297440896 ARI: 8 IMU
 SG_ RateX : 0|16@1+ (0.0078125,-250) [-250|250] "deg/s" ECU
 SG_ RateY : 16|16@1+ (0.0078125,-250) [-250|250] "deg/s" ECU
 SG_ RateZ : 32|16@1+ (0.0078125,-250) [-250|250] "deg/s" ECU
 SG_ RateMerit : 48|6@1+ (1,0) [0|63] "" ECU
 SG_ RateLatency : 56|8@1+ (0.5,0) [0|125] "ms" ECU

BO_ 2297441664 ACCS: 8 IMU
 SG_ ForceX : 0|16@1+ (0.01,-320) [-320|322.55] "m/s2" ECU
 SG_ ForceY : 16|16@1+ (0.01,-320) [-320|322.55] "m/s2" ECU
 SG_ ForceZ : 32|16@1+ (0.01,-320) [-320|322.55] "m/s2" ECU
 SG_ ForceMerit : 48|6@1+ (1,0) [0|63] "" ECU
 SG_ ForceLatency : 56|8@1+ (0.5,0) [0|125] "ms" ECU

BO_ 206 WHEELS: 8 DRIVE
 SG_ SpeedFL : 0|16@1- (0.0625,0) [-2048|2047] "km/h" ECU
 SG_ SpeedFR : 16|16@1- (0.0625,0) [-2048|2047] "km/h" ECU
 SG_ SpeedRL : 32|16@1- (0.0625,0) [-2048|2047] "km/h" ECU
 SG_ SpeedRR : 48|16@1- (0.0625,0) [-2048|2047] "km/h" ECU
)";

constexpr const char* kXsensDbc = R"(VERSION ""

NS_ :

BS_:

BU_: MTI NAV ECU

BO_ 5 SampleTime: 4 MTI
 SG_ Time : 7|32@0+ (1,0) [0|4294967295] "us" ECU

BO_ 6 GroupCounter: 2 MTI
 SG_ GroupCount : 7|16@0+ (1,0) [0|65535] "" ECU

BO_ 50 RateOfTurn: 6 MTI
 SG_ GyrX : 7|16@0- (0.001953125,0) [-64|64] "rad/s" ECU
 SG_ GyrY : 23|16@0- (0.001953125,0) [-64|64] "rad/s" ECU
 SG_ GyrZ : 39|16@0- (0.001953125,0) [-64|64] "rad/s" ECU

BO_ 52 Acceleration: 6 MTI
 SG_ AccX : 7|16@0- (0.00390625,0) [-128|128] "m/s2" ECU
 SG_ AccY : 23|16@0- (0.00390625,0) [-128|128] "m/s2" ECU
 SG_ AccZ : 39|16@0- (0.00390625,0) [-128|128] "m/s2" ECU
)";

constexpr const char* kXsensVelocityDbc = R"(
BO_ 118 Velocity: 6 MTI
 SG_ VelX : 7|16@0- (0.015625,0) [-512|512] "m/s" ECU
 SG_ VelY : 23|16@0- (0.015625,0) [-512|512] "m/s" ECU
 SG_ VelZ : 39|16@0- (0.015625,0) [-512|512] "m/s" ECU
)";

constexpr const char* kBodyVelocityDbc = R"(
BO_ 672 BodyVelocity: 8 NAV
 SG_ VelX : 0|16@1- (0.001,0) [-32|32] "m/s" ECU
 SG_ VelY : 16|16@1- (0.001,0) [-32|32] "m/s" ECU
 SG_ VelZ : 32|16@1- (0.001,0) [-32|32] "m/s" ECU
 SG_ VelocityCount : 48|8@1+ (1,0) [0|255] "" ECU
 SG_ State : 56|8@1+ (1,0) [0|3] "" ECU
)";

struct Role {
  const char* message;
  const char* signal;
  CanRole role;
  CanUnit unit = CanUnit::kSi;
  double scale = 1;
};

void add_roles(CanMotionConfig& can, std::initializer_list<Role> roles, std::uint64_t raw_max = UINT64_MAX) {
  for (const Role& role : roles) {
    CanSignalRole& entry = can.signals[can.signal_count++];
    std::strcpy(entry.message, role.message);
    std::strcpy(entry.signal, role.signal);
    entry.role = role.role;
    entry.unit = role.unit;
    entry.scale = role.scale;
    entry.raw_max = raw_max;
  }
}

BusLayout car() {
  constexpr CanUnit kDeg = CanUnit::kDegPerSecond;
  constexpr CanUnit kG = CanUnit::kStandardGravity;
  BusLayout layout;
  layout.odometry_period_us = 12000;
  layout.wheels = true;
  layout.track_m = 1.53;
  layout.wheelbase_m = 2.7;
  layout.dbc = kCarDbc;
  // The front wheels roll on wider circles: only the rear ones tell the speed of the rear axle.
  add_roles(layout.can, {{"MM_TX1", "YawRate", CanRole::kGyroZ, kDeg},
                         {"MM_TX1", "AccelY", CanRole::kAccelY, kG},
                         {"MM_TX1", "Counter1", CanRole::kCounter},
                         {"MM_TX2", "RollRate", CanRole::kGyroX, kDeg, -1},
                         {"MM_TX2", "AccelX", CanRole::kAccelX, kG},
                         {"MM_TX2", "Counter2", CanRole::kCounter},
                         {"MM_TX3", "PitchRate", CanRole::kGyroY, kDeg},
                         {"MM_TX3", "AccelZ", CanRole::kAccelZ, kG},
                         {"MM_TX3", "Counter3", CanRole::kCounter},
                         {"WHEEL_SPEEDS", "WheelSpeedRR", CanRole::kWheelSpeed, CanUnit::kKmPerHour},
                         {"WHEEL_SPEEDS", "WheelSpeedRL", CanRole::kWheelSpeed, CanUnit::kKmPerHour}});
  layout.can.group_window_us = 4000;
  layout.motion.model = MotionModel::kWheeled;
  layout.motion.wheel_noise_m_s = 0.03;
  layout.others = {{0x025, false, 8, 12000},  {0x0B4, false, 8, 24000}, {0x1C4, false, 8, 24000},
                   {0x224, false, 8, 30000},  {0x2C1, false, 8, 32000}, {0x3B7, false, 8, 48000},
                   {0x399, false, 8, 100000}, {0x620, false, 8, 300000}};
  return layout;
}

BusLayout delivery_robot() {
  constexpr CanUnit kDeg = CanUnit::kDegPerSecond;
  constexpr std::uint64_t kLargestValid = 0xFAFF;
  BusLayout layout;
  layout.bits_per_s = 250000;
  layout.wheels = true;
  layout.track_m = 0.46;
  layout.wheelbase_m = 0.42;
  layout.dbc = kDeliveryDbc;
  add_roles(layout.can,
            {{"ARI", "RateX", CanRole::kGyroX, kDeg},
             {"ARI", "RateY", CanRole::kGyroY, kDeg},
             {"ARI", "RateZ", CanRole::kGyroZ, kDeg},
             {"ACCS", "ForceX", CanRole::kAccelX},
             {"ACCS", "ForceY", CanRole::kAccelY},
             {"ACCS", "ForceZ", CanRole::kAccelZ}},
            kLargestValid);
  add_roles(layout.can, {{"WHEELS", "SpeedRL", CanRole::kWheelSpeed, CanUnit::kKmPerHour},
                         {"WHEELS", "SpeedRR", CanRole::kWheelSpeed, CanUnit::kKmPerHour}});
  layout.can.gyro_axes = {{1, -2, -3}};
  layout.can.accel_axes = {{1, -2, -3}};
  layout.can.match_parameter_group = true;
  layout.motion.model = MotionModel::kWheeled;
  layout.motion.wheel_noise_m_s = 0.02;
  layout.others = {{0x18FEF180, true, 8, 100000},
                   {0x18FF0380, true, 8, 20000},
                   {0x701, false, 1, 500000},
                   {0x181, false, 8, 20000}};
  return layout;
}

BusLayout xsens(BusRobot robot) {
  const bool drone = robot == BusRobot::kDrone;
  const char* const message = drone ? "Velocity" : "BodyVelocity";
  BusLayout layout;
  layout.dbc = std::string(kXsensDbc) + (drone ? kXsensVelocityDbc : kBodyVelocityDbc);
  layout.gyro_frame = 2;
  layout.odometry_period_us = drone ? 20000 : robot == BusRobot::kHand ? 33333 : 10000;
  add_roles(layout.can, {{"RateOfTurn", "GyrX", CanRole::kGyroX},
                         {"RateOfTurn", "GyrY", CanRole::kGyroY},
                         {"RateOfTurn", "GyrZ", CanRole::kGyroZ},
                         {"Acceleration", "AccX", CanRole::kAccelX},
                         {"Acceleration", "AccY", CanRole::kAccelY},
                         {"Acceleration", "AccZ", CanRole::kAccelZ},
                         {message, "VelX", CanRole::kVelocityX},
                         {message, "VelY", CanRole::kVelocityY},
                         {message, "VelZ", CanRole::kVelocityZ}});
  layout.motion.wheel_noise_m_s = drone ? 0.03 : robot == BusRobot::kHand ? 0.012 : 0.003;
  layout.others = {{0x011, false, 4, 100000},
                   {0x021, false, 8, 10000},
                   {0x051, false, 2, 1000000},
                   {0x052, false, 4, 20000}};
  return layout;
}

}  // namespace

BusLayout bus_layout(BusRobot robot) {
  switch (robot) {
    case BusRobot::kCar:
      return car();
    case BusRobot::kDeliveryRobot:
      return delivery_robot();
    case BusRobot::kDrone:
    case BusRobot::kHand:
    case BusRobot::kArm:
      return xsens(robot);
  }
  throw std::invalid_argument("no such robot");
}

}  // namespace egofocus::citysim
