// The filter on simulated drives with stated faults: how fast, how accurate, how honest.
#include "pipeline/ego_motion.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "pipeline/robot_simulator.hpp"

using namespace egofocus;
using namespace egofocus::test;

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

SensorFaults random_faults(std::uint64_t seed) {
  Random random(seed ^ 0x5eed);
  SensorFaults faults;
  for (double& b : faults.gyro_bias_rad_s.v) b = 0.02 * random.gauss();
  for (double& b : faults.accel_bias_m_s2.v) b = 0.05 * random.gauss();
  faults.wheel_scale = 0.02 * random.gauss();
  return faults;
}

struct Drive {
  Path path;
  SensorFaults faults;
  std::uint64_t seed = 1;
  MotionModel model = MotionModel::kWheeled;
  bool wheels = true;  ///< else body velocity
  bool gyro = true;
  bool accel = true;
  double duration_s = 38;
  double dropout_from_s = 1e9;  ///< odometry is silent for one second
};

struct Outcome {
  double bias_error_deg_s[64] = {};  ///< norm, at whole seconds
  double worst_velocity = 0;         ///< relative, where the speed is above 3 m/s (drone: 1 m/s) and t > settle_s
  double worst_in_dropout = 0;
  std::uint64_t checked = 0;
  std::uint64_t velocity_outside = 0;
  std::uint64_t bias_outside = 0;
  std::uint64_t standing = 0;
  std::uint64_t rejected = 0;
  std::unique_ptr<EgoMotion> ego;
};

template <typename Visit>
void simulate(const Drive& drive, EgoMotion& ego, Visit visit) {
  RobotSimulator robot(drive.path, drive.faults, drive.seed);
  const auto steps = static_cast<int>(drive.duration_s * 1000);
  for (int i = 0; i < steps; ++i) {
    robot.step();
    if (i % 5 == 0) {
      ImuSample sample = robot.imu();
      sample.has_gyro = drive.gyro;
      sample.has_accel = drive.accel;
      if (drive.gyro || drive.accel) ego.add(sample);
    }
    const bool silent = robot.t_s() >= drive.dropout_from_s && robot.t_s() < drive.dropout_from_s + 1;
    if (i % 20 == 7 && !silent) ego.add(drive.wheels ? robot.wheel() : robot.body_velocity());
    if (i % 50 == 49) {
      ego.advance(robot.t_us());
      visit(robot);
    }
  }
}

Outcome run(const Drive& drive, double settle_s, double least_speed_m_s) {
  MotionConfig config;
  config.model = drive.model;
  Outcome out;
  out.ego = std::make_unique<EgoMotion>(config);
  simulate(drive, *out.ego, [&](const RobotSimulator& robot) {
    const VelocityFilter& filter = out.ego->filter();
    const Triple truth = robot.velocity();
    double error2 = 0;
    double speed2 = 0;
    double bias2 = 0;
    for (int i = 0; i < 3; ++i) {
      const double off = filter.velocity_m_s()[i] - truth.v[i];
      const double bias_off = filter.gyro_bias_rad_s()[i] - drive.faults.gyro_bias_rad_s.v[i];
      error2 += off * off;
      speed2 += truth.v[i] * truth.v[i];
      bias2 += bias_off * bias_off;
      const auto& p = filter.covariance();
      ++out.checked;
      if (off * off > 9 * p(i, i)) ++out.velocity_outside;
      if (bias_off * bias_off > 9 * p(6 + i, 6 + i)) ++out.bias_outside;
    }
    if (filter.standing()) ++out.standing;
    const double t = robot.t_s();
    if (static_cast<int>(t) < 64) out.bias_error_deg_s[static_cast<int>(t)] = std::sqrt(bias2) / kDegree;
    if (speed2 < least_speed_m_s * least_speed_m_s || t < settle_s) return;
    const double relative = std::sqrt(error2 / speed2);
    out.worst_velocity = std::max(out.worst_velocity, relative);
    if (t >= drive.dropout_from_s && t < drive.dropout_from_s + 1) {
      out.worst_in_dropout = std::max(out.worst_in_dropout, relative);
    }
  });
  out.rejected = out.ego->odometry_counters().rejected;
  return out;
}

SensorFaults stated_faults() {
  SensorFaults faults;
  faults.gyro_bias_rad_s = {{0.02, -0.015, 0.025}};
  faults.accel_bias_m_s2 = {{0.05, -0.04, 0.06}};
  return faults;
}

}  // namespace

TEST_CASE("a car: bias, velocity in straight and turns, wheel dropout") {
  for (double dropout_s : {1e9, 11.0, 16.0, 23.0}) {
    Drive drive{car_path(), stated_faults()};
    drive.dropout_from_s = dropout_s;
    const Outcome out = run(drive, 4, 3);
    WARN("car, dropout at " << dropout_s << " s: bias error at 5, 10, 30 s " << out.bias_error_deg_s[5] << ", "
                            << out.bias_error_deg_s[10] << ", " << out.bias_error_deg_s[30]
                            << " deg/s; worst velocity error " << 100 * out.worst_velocity << " % (in the dropout "
                            << 100 * out.worst_in_dropout << " %); rejected " << out.rejected << "; outside "
                            << out.velocity_outside << " " << out.bias_outside << " of " << out.checked << " standing " << out.standing);
    CHECK(out.bias_error_deg_s[10] < 0.1);
    CHECK(out.worst_velocity < 0.03);
  }
}

TEST_CASE("a car already driving; a drone; a hand-held body") {
  Drive car{car_path(), stated_faults()};
  const Path whole = car.path;
  car.path = {[whole](double t) { return whole.velocity_m_s(t + 10); }, [whole](double t) { return whole.rate_rad_s(t + 10); }};
  car.duration_s = 20;
  Drive drone{drone_path(), stated_faults()};
  drone.model = MotionModel::kFree;
  drone.wheels = false;
  drone.duration_s = 30;
  int i = 0;
  for (const Drive& drive : {car, drone}) {
    const Outcome out = run(drive, 2, 1);
    WARN("drive " << i++ << ": bias error at 5, 10, 15 s " << out.bias_error_deg_s[5] << ", "
                            << out.bias_error_deg_s[10] << ", " << out.bias_error_deg_s[15]
                            << " deg/s; worst velocity error " << 100 * out.worst_velocity << " %; rejected " << out.rejected << "; outside "
                            << out.velocity_outside << " " << out.bias_outside << " of " << out.checked << " standing " << out.standing);
  }
}

TEST_CASE("3-sigma bounds") {
  std::uint64_t checked = 0, v = 0, b = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Drive drive{car_path(), random_faults(seed), seed};
    if (seed % 2) { drive.path = drone_path(); drive.model = MotionModel::kFree; drive.wheels = false; }
    const Outcome out = run(drive, 4, 3);
    checked += out.checked; v += out.velocity_outside; b += out.bias_outside;
    WARN(seed << " " << out.velocity_outside << " " << out.bias_outside << " of " << out.checked << " worst " << out.worst_velocity << " bias10 " << out.bias_error_deg_s[10] << " scale " << out.ego->filter().wheel_scale() << " true " << drive.faults.wheel_scale);
  }
  WARN(checked << " " << v << " " << b);
}
