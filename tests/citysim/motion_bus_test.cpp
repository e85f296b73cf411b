// The bus without faults says what the trajectory does, bit by bit and through the library's decoder; with
// faults it says what they predict.
#include "citysim/motion_bus.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "citysim/robots.hpp"
#include "hal/can_motion_decoder.hpp"

using namespace egofocus;
using namespace egofocus::citysim;
using namespace egofocus::citysim::test;

namespace {

constexpr double kRadPerDeg = 0.017453292519943295;

struct BusSamples {
  std::vector<ImuSample> gyro;
  std::vector<ImuSample> accel;
  std::vector<OdometrySample> odometry;
  CanMotionCounters counters;
};

BusSamples decoded(const MotionBus& bus) {
  const auto dbc = std::make_unique<Dbc>();
  REQUIRE(read_dbc(bus.dbc, {}, *dbc).ok());
  const auto decoder = std::make_unique<CanMotionDecoder>();
  REQUIRE(decoder->configure(bus.can, *dbc).ok());
  BusSamples all;
  MotionSamples out;
  for (const CanFrame& frame : bus.frames) {
    decoder->feed(frame, out);
    for (std::size_t i = 0; i < out.imu_count; ++i)
      (out.imu[i].has_gyro ? all.gyro : all.accel).push_back(out.imu[i]);
    for (std::size_t i = 0; i < out.odometry_count; ++i) all.odometry.push_back(out.odometry[i]);
  }
  all.counters = decoder->counters();
  return all;
}

/// How far `value` lies outside of what truth(t) is around the sample's time, component by component.
template <typename Truth>
double outside(const double (&value)[3], std::int64_t t_us, Truth truth) {
  double worst = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    double low = 1e9;
    double high = -1e9;
    for (int k = -15; k <= 15; ++k) {
      const double x = truth(static_cast<double>(t_us) * 1e-6 + k * 1e-4)[i];
      low = std::min(low, x);
      high = std::max(high, x);
    }
    worst = std::max({worst, low - value[i], value[i] - high});
  }
  return worst;
}

Trajectory circle(double radius_m, double speed_m_s, double duration_s) {
  std::vector<Trajectory::Control> controls;
  constexpr double kStep_s = 0.01;
  const double rate = speed_m_s / radius_m;
  for (int i = -1; i < static_cast<int>(duration_s / kStep_s) + 2; ++i) {
    const double yaw = rate * i * kStep_s;
    controls.push_back({{radius_m * std::sin(yaw), radius_m * (1 - std::cos(yaw)), 0}, yaw, 0, 0});
  }
  return {std::move(controls), kStep_s};
}

std::vector<CanFrame> frames_of(const MotionBus& bus, std::uint32_t id) {
  std::vector<CanFrame> found;
  for (const CanFrame& frame : bus.frames) {
    if (frame.id == id) found.push_back(frame);
  }
  return found;
}

double motorola(const CanFrame& frame, std::size_t byte) {
  return frame.data[byte] * 256.0 + frame.data[byte + 1];
}
double intel_signed(const CanFrame& frame, std::size_t byte) {
  const int raw = frame.data[byte] + 256 * frame.data[byte + 1];
  return raw < 32768 ? raw : raw - 65536;
}

}  // namespace

TEST_CASE("without faults each robot's bus says what the trajectory does") {
  struct Row {
    Robot robot;
    double gyro_step;
    double accel_step;
    double odometry_step;
  };
  for (const Row& row :
       {Row{Robot::kCar, 0.005 * kRadPerDeg, 0.000127465 * 9.80665, 0.01 / 3.6},
        Row{Robot::kCorridor, kRadPerDeg / 128, 0.01, 0.0625 / 3.6},
        Row{Robot::kDrone, 1.0 / 512, 1.0 / 256, 1.0 / 64}, Row{Robot::kHand, 1.0 / 512, 1.0 / 256, 0.001},
        Row{Robot::kArm, 1.0 / 512, 1.0 / 256, 0.001}}) {
    constexpr double kDuration_s = 30;
    const Trajectory trajectory = move(row.robot, kDuration_s, 2);
    BusFaults faults;
    faults.imu_latency_us = 5000;
    faults.odometry_latency_us = 2000;
    const MotionBus bus = motion_bus(trajectory, bus_of(row.robot), faults, camera_of(row.robot), 1);
    const BusSamples all = decoded(bus);
    double gyro = 0;
    double accel = 0;
    double odometry = 0;
    for (const ImuSample& s : all.gyro) {
      gyro = std::max(
          gyro, outside(s.gyro_rad_s, s.t_us, [&](double t) { return trajectory.body_at(t).rate_rad_s; }));
    }
    for (const ImuSample& s : all.accel) {
      accel = std::max(
          accel, outside(s.accel_m_s2, s.t_us, [&](double t) {
            const RigidState b = trajectory.body_at(t);
            const Mat3& r = b.pose.rotation;
            return b.acceleration_m_s2 + Vec3{9.80665 * r[2][0], 9.80665 * r[2][1], 9.80665 * r[2][2]};
          }));
    }
    for (OdometrySample s : all.odometry) {
      const bool wheel = s.kind == OdometrySample::Kind::kWheelSpeed;
      odometry = std::max(odometry, outside(s.velocity_m_s, s.t_us, [&](double t) {
                            const Vec3 v = trajectory.body_at(t).velocity_m_s;
                            return wheel ? Vec3{v[0], 0, 0} : v;
                          }));
    }
    WARN(name_of(row.robot) << ": beyond the truth around a sample: gyro " << gyro / row.gyro_step
                            << ", accelerometer " << accel / row.accel_step << ", odometry "
                            << odometry / row.odometry_step << " steps; bus load " << bus.load);
    CHECK(gyro < 0.51 * row.gyro_step);
    CHECK(accel < 0.51 * row.accel_step);
    CHECK(odometry < 0.51 * row.odometry_step);
    CHECK(all.gyro.size() >= 2999);
    CHECK(all.accel.size() >= 2999);
    CHECK(all.odometry.size() >= 890);
    CHECK(all.counters.samples_incomplete == 0);
    CHECK(all.counters.invalid_values == 0);
    CHECK(all.counters.frames_short == 0);
    CHECK(all.counters.frames_unknown > 1000);
    CHECK(bus.load > 0.03);
    CHECK(bus.load < 0.5);
  }
}

TEST_CASE("wheels in a turn, by hand: outer ones faster, front ones on wider circles") {
  const double v = 5;
  const double r = 10;
  const BusFaults no_faults;
  const CanFrame car =
      frames_of(motion_bus(circle(r, v, 4), BusRobot::kCar, no_faults, {}, 1), 0x0AA).at(100);
  const auto kmh = [&](std::size_t byte) { return motorola(car, byte) * 0.01 - 67.67; };
  const double w = v / r;
  CHECK(kmh(4) == Approx(3.6 * (v + w * 1.53 / 2)).margin(0.006));                     // rear right
  CHECK(kmh(6) == Approx(3.6 * (v - w * 1.53 / 2)).margin(0.006));                     // rear left
  CHECK(kmh(0) == Approx(3.6 * std::hypot(v + w * 1.53 / 2, 2.7 * w)).margin(0.006));  // front right
  CHECK(kmh(2) == Approx(3.6 * std::hypot(v - w * 1.53 / 2, 2.7 * w)).margin(0.006));  // front left

  const CanFrame robot =
      frames_of(motion_bus(circle(2, 1.2, 4), BusRobot::kDeliveryRobot, no_faults, {}, 1), 0x0CE).at(50);
  CHECK(intel_signed(robot, 4) * 0.0625 == Approx(3.6 * (1.2 - 0.6 * 0.23)).margin(0.032));
  CHECK(intel_signed(robot, 6) * 0.0625 == Approx(3.6 * (1.2 + 0.6 * 0.23)).margin(0.032));

  BusFaults silent;
  silent.odometry_zero_below_m_s = 1.5 / 3.6;
  const CanFrame slow =
      frames_of(motion_bus(circle(50, 0.3, 4), BusRobot::kCar, silent, {}, 1), 0x0AA).at(100);
  for (const std::size_t byte : {0u, 2u, 4u, 6u}) CHECK(motorola(slow, byte) == 6767);
}

TEST_CASE("inertial frames by hand: a circle's yaw rate, its centripetal force and gravity") {
  const BusFaults no_faults;
  const Trajectory trajectory = circle(10, 5, 4);
  const MotionBus car = motion_bus(trajectory, BusRobot::kCar, no_faults, {}, 1);
  const CanFrame tx1 = frames_of(car, 0x174).at(100);
  const double yaw = (tx1.data[0] + 256 * tx1.data[1]) * 0.005 - 163.84;
  const double ay = (tx1.data[4] + 256 * tx1.data[5]) * 0.000127465 - 4.1768;
  CHECK(yaw == Approx(0.5 / kRadPerDeg).margin(0.0026));
  CHECK(ay == Approx(2.5 / 9.80665).margin(1e-4));
  CHECK(frames_of(car, 0x178).at(100).data[6] == tx1.data[6]);
  CHECK(frames_of(car, 0x174).at(101).data[6] == ((tx1.data[6] + 1) & 15));

  const MotionBus robot = motion_bus(trajectory, BusRobot::kDeliveryRobot, no_faults, {}, 1);
  const CanFrame accs = frames_of(robot, 0x08F02D80).at(100);
  CHECK(accs.extended);
  CHECK((accs.data[4] + 256 * accs.data[5]) * 0.01 - 320 == Approx(-9.80665).margin(0.0051));  // z is down

  const MotionBus drone = motion_bus(trajectory, BusRobot::kDrone, no_faults, {}, 1);
  CHECK(motorola(frames_of(drone, 0x032).at(100), 4) == 256);   // 0.5 rad/s
  CHECK(motorola(frames_of(drone, 0x034).at(100), 4) == 2511);  // 9.80665 * 256
  CHECK(motorola(frames_of(drone, 0x076).at(100), 0) == 320);   // 5 m/s
}

TEST_CASE("faults are what they say: bias, noise, scale, silences, lost frames") {
  const std::vector<Trajectory::Control> still(7, {{0, 0, 0}, 0, 0, 0});
  BusFaults faults;
  faults.gyro_bias_rad_s = {0.01, -0.02, 0.015};
  faults.gyro_noise_rad_s = 0.002;
  faults.accel_bias_m_s2 = {0.05, 0, -0.1};
  faults.accel_noise_m_s2 = 0.05;
  faults.odometry_noise_m_s = 0.02;
  faults.dropout_every_s = 8;
  faults.lost_frame_share = 0.01;
  faults.jitter_us = 400;
  const MotionBus bus = motion_bus(Trajectory(still, 30), BusRobot::kHand, faults, {}, 3);
  const BusSamples all = decoded(bus);
  double mean = 0;
  double square = 0;
  for (const ImuSample& s : all.gyro) {
    mean += s.gyro_rad_s[1] / static_cast<double>(all.gyro.size());
    square += s.gyro_rad_s[1] * s.gyro_rad_s[1] / static_cast<double>(all.gyro.size());
  }
  CHECK(mean == Approx(-0.02).margin(0.0002));
  CHECK(std::sqrt(square - mean * mean) == Approx(0.00208).epsilon(0.05));  // with a step of 1/512
  double up = 0;
  for (const ImuSample& s : all.accel) up += s.accel_m_s2[2] / static_cast<double>(all.accel.size());
  CHECK(up == Approx(9.80665 - 0.1).margin(0.003));

  CHECK(bus.dropouts_us.size() >= 6);
  for (const OdometrySample& s : all.odometry) {
    for (const auto& [from_us, to_us] : bus.dropouts_us)
      REQUIRE((s.t_us < from_us + 1500 || s.t_us >= to_us - 1500));
  }
  for (const auto& [from_us, to_us] : bus.dropouts_us) {
    CHECK(to_us - from_us >= 100000);
    CHECK(to_us - from_us <= 1000000);
  }
  CHECK(bus.lost_frames > 300);
  CHECK(bus.lost_frames < 700);
  CHECK(bus.frames.size() > bus.motion_frames);
  CHECK(all.gyro.size() < 11999);
}

TEST_CASE("drawn faults stay within what is promised, and differ") {
  for (const BusRobot robot :
       {BusRobot::kCar, BusRobot::kDeliveryRobot, BusRobot::kDrone, BusRobot::kHand, BusRobot::kArm}) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      const BusFaults f = draw_bus_faults(robot, seed);
      for (const double bias : f.gyro_bias_rad_s) REQUIRE(std::abs(bias) <= 1.0001 * kRadPerDeg);
      REQUIRE(std::abs(f.odometry_scale) <= 0.02);
      REQUIRE(f.imu_latency_us >= 500);
      REQUIRE(f.imu_latency_us + f.jitter_us <= 10000);
    }
    CHECK(draw_bus_faults(robot, 1).odometry_scale != draw_bus_faults(robot, 2).odometry_scale);
  }
}
