// The filter on simulated drives with stated faults: how soon, how accurate, how honest, and the same bits
// everywhere.
#include "pipeline/ego_motion.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <memory>

#include "pipeline/drive.hpp"

using namespace egofocus;
using namespace egofocus::test;

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

struct Outcome {
  double bias_at_10_deg_s = 0;  ///< norm of the gyro bias error
  double worst_velocity = 0;    ///< |error| / |velocity| above 3 m/s (drone: 2 m/s), after 4 s
  double worst_in_dropout = 0;
  std::uint64_t compared = 0;
  std::uint64_t velocity_outside = 0;  ///< beyond 3 sigma, by component
  std::uint64_t bias_outside = 0;
  double worst_standing_m_s = 0;
  std::uint64_t standing = 0;
  std::uint64_t rejected = 0;

  [[nodiscard]] double velocity_inside() const {
    return 1 - static_cast<double>(velocity_outside) / static_cast<double>(compared);
  }
  [[nodiscard]] double bias_inside() const {
    return 1 - static_cast<double>(bias_outside) / static_cast<double>(compared);
  }
};

double norm(const double (&v)[3]) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

void judge(const Drive& drive, const RobotSimulator& robot, const VelocityFilter& filter, Outcome& out) {
  const Triple truth = robot.velocity();
  double error[3];
  double bias_error[3];
  for (int i = 0; i < 3; ++i) {
    error[i] = filter.velocity_m_s()[i] - truth.v[i];
    bias_error[i] = filter.gyro_bias_rad_s()[i] - drive.faults.gyro_bias_rad_s.v[i];
    const int bias = VelocityFilter::kGyroBias + i;
    ++out.compared;
    if (error[i] * error[i] > 9 * filter.covariance()(i, i)) ++out.velocity_outside;
    if (bias_error[i] * bias_error[i] > 9 * filter.covariance()(bias, bias)) ++out.bias_outside;
  }
  if (filter.standing()) {
    ++out.standing;
    out.worst_standing_m_s = std::max(out.worst_standing_m_s, norm(error));
  }
  const double t = robot.t_s();
  if (t <= 10) out.bias_at_10_deg_s = norm(bias_error) / kDegree;
  if (t < 4 || norm(truth.v) < (drive.wheels ? 3 : 2)) return;
  const double relative = norm(error) / norm(truth.v);
  out.worst_velocity = std::max(out.worst_velocity, relative);
  const bool dropout = t >= drive.dropout_from_s && t < drive.dropout_from_s + 1;
  if (dropout) out.worst_in_dropout = std::max(out.worst_in_dropout, relative);
}

Outcome run(const Drive& drive) {
  const auto ego = std::make_unique<EgoMotion>(config_of(drive));
  Outcome out;
  simulate(
      drive, [&](const auto& sample) { ego->add(sample); },
      [&](const RobotSimulator& robot) {
        ego->advance(robot.t_us());
        judge(drive, robot, ego->filter(), out);
      });
  out.rejected = ego->odometry_counters().rejected;
  return out;
}

/// A row of the table that the tests print.
void print(const char* name, const Outcome& out) {
  WARN(name << ": bias error at 10 s " << out.bias_at_10_deg_s << " deg/s, worst velocity error "
            << 100 * out.worst_velocity << " %, within 3 sigma: velocity " << 100 * out.velocity_inside()
            << " %, bias " << 100 * out.bias_inside() << " %");
}

}  // namespace

TEST_CASE("a car: bias, velocity in straights and turns, standstill") {
  const Outcome out = run(car_drive());
  print("car", out);
  CHECK(out.bias_at_10_deg_s < 0.1);
  CHECK(out.worst_velocity < 0.03);
  CHECK(out.rejected == 0);
  CHECK(out.standing > 40);
  CHECK(out.worst_standing_m_s < 0.025);  // half the stated wheel noise
}

TEST_CASE("a car whose wheels are silent for a second") {
  for (double from_s : {11.0, 16.0, 23.0}) {  // steady, in the left turn, in the right turn
    Drive drive = car_drive();
    drive.duration_s = 26;
    drive.dropout_from_s = from_s;
    const Outcome out = run(drive);
    WARN("dropout at " << from_s << " s: worst velocity error " << 100 * out.worst_in_dropout << " %");
    CHECK(out.worst_in_dropout > 0);
    CHECK(out.worst_in_dropout < 0.03);
    CHECK(out.rejected == 0);
  }
}

TEST_CASE("a car that already drives: the velocity is right, the bias honest") {
  Drive drive = car_drive();
  const Path whole = drive.path;
  drive.path = {[whole](double t) { return whole.velocity_m_s(t + 10); },
                [whole](double t) { return whole.rate_rad_s(t + 10); }};
  drive.duration_s = 15;
  const Outcome out = run(drive);
  print("car, started at 12 m/s", out);
  CHECK(out.worst_velocity < 0.03);
  CHECK(out.velocity_inside() >= 0.99);
  CHECK(out.bias_inside() >= 0.99);
}

TEST_CASE("stop and go, with wheels whose pulses stop below 1.5 km/h and with others") {
  // Stands for 3 s, then 5 m/s within 2.5 s, and so on.
  const auto speed = [](double t) {
    const double s = t - 9 * floor_of(t / 9);
    return 5 * ramp(s, 3, 5.5) * (1 - ramp(s, 6.5, 9));
  };
  for (const double silent_below_m_s : {0.0, 1.5 / 3.6}) {
    Drive drive = car_drive();
    drive.path = {[speed](double t) {
                    return Triple{{speed(t), 0, 0}};
                  },
                  [](double) {
                    return Triple{{0, 0, 0}};
                  }};
    drive.faults.wheel_silent_below_m_s = silent_below_m_s;
    const auto ego = std::make_unique<EgoMotion>(config_of(drive));
    double worst_slow_m_s = 0;
    double worst_scale = 0;
    simulate(
        drive, [&](const auto& sample) { ego->add(sample); },
        [&](const RobotSimulator& robot) {
          ego->advance(robot.t_us());
          if (robot.t_s() < 12) return;
          const double v = robot.velocity().v[0];
          const double error_m_s = std::abs(ego->filter().velocity_m_s()[0] - v);
          if (v < 1) worst_slow_m_s = std::max(worst_slow_m_s, error_m_s);
          worst_scale = std::max(worst_scale, std::abs(ego->filter().wheel_scale() - 0.02));
        });
    WARN("stop and go, silent below " << silent_below_m_s << " m/s: worst velocity error below 1 m/s "
                                      << worst_slow_m_s << " m/s, worst scale error " << worst_scale);
    CHECK(worst_slow_m_s < 0.09);
    CHECK(worst_scale < 0.0045);
    CHECK(ego->odometry_counters().rejected == 0);
  }
}

TEST_CASE("a drone with body velocity") {
  const Outcome out = run(drone_drive());
  print("drone", out);
  CHECK(out.bias_at_10_deg_s < 0.1);
  CHECK(out.worst_velocity < 0.03);
  CHECK(out.standing == 0);
}

TEST_CASE("without an accelerometer velocity follows the wheels") {
  Drive drive = car_drive();
  drive.accel = false;
  const Outcome out = run(drive);
  print("car without accelerometer", out);
  CHECK(out.bias_at_10_deg_s < 0.1);
  CHECK(out.worst_velocity < 0.05);
  CHECK(out.velocity_inside() >= 0.99);
}

TEST_CASE("without a gyro velocity follows the wheels") {
  Drive drive = car_drive();
  drive.gyro = false;
  drive.accel = false;
  const Outcome out = run(drive);
  print("car without IMU", out);
  CHECK(out.worst_velocity < 0.08);
}

TEST_CASE("3-sigma bounds hold 99 % of the time over drives with random faults", "[long]") {
  Outcome total;
  double worst_bias_deg_s = 0;
  double worst_velocity = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Drive drive = seed % 2 ? car_drive() : drone_drive();
    drive.seed = seed;
    drive.duration_s = seed % 2 ? 30 : 15;
    Random random(seed ^ 0x5eed);
    for (double& b : drive.faults.gyro_bias_rad_s.v) b = 0.02 * random.gauss();
    for (double& b : drive.faults.accel_bias_m_s2.v) b = 0.05 * random.gauss();
    drive.faults.wheel_scale = 0.02 * random.gauss();
    const Outcome out = run(drive);
    total.compared += out.compared;
    total.velocity_outside += out.velocity_outside;
    total.bias_outside += out.bias_outside;
    worst_bias_deg_s = std::max(worst_bias_deg_s, out.bias_at_10_deg_s);
    worst_velocity = std::max(worst_velocity, out.worst_velocity);
  }
  WARN("12 drives (6 car, 6 drone): within 3 sigma: velocity "
       << 100 * total.velocity_inside() << " %, bias " << 100 * total.bias_inside()
       << " %; worst bias error at 10 s " << worst_bias_deg_s << " deg/s, worst velocity error "
       << 100 * worst_velocity << " %");
  CHECK(total.velocity_inside() >= 0.99);
  CHECK(total.bias_inside() >= 0.99);
  CHECK(worst_bias_deg_s < 0.1);
}

TEST_CASE("the same bits on every machine") {
  Drive drive = car_drive();
  drive.duration_s = 12;
  const auto ego = std::make_unique<EgoMotion>(config_of(drive));
  const auto track = std::make_unique<MotionTrack>();
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto mix = [&hash](double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    for (int byte = 0; byte < 8; ++byte) hash = (hash ^ ((bits >> (8 * byte)) & 0xff)) * 0x100000001b3u;
  };
  simulate(
      drive, [&](const auto& sample) { ego->add(sample); },
      [&](const RobotSimulator& robot) {
        ego->advance(robot.t_us());
        const CameraMotion motion = ego->at_end(robot.t_us());
        for (double v : motion.velocity_m_s) mix(v);
        for (double v : motion.angular_rate_rad_s) mix(v);
        for (double v : motion.velocity_covariance_m2_s2) mix(v);
        if (!ego->track(robot.t_us() - 200000, robot.t_us(), *track)) return;
        for (double v : track->knots[0].rotation) mix(v);
        for (double v : track->knots[0].centre_m) mix(v);
      });
  INFO("hash " << std::hex << hash);
  CHECK(hash == 0x06dd705cc85cd9f7u);
}
