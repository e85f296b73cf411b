// The trajectory's velocities, rates and accelerations against differences of its poses, which rest on none
// of their formulas.
#include "citysim/trajectory.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "citysim/random.hpp"
#include "citysim/robots.hpp"

using namespace egofocus::citysim;
using namespace egofocus::citysim::test;

namespace {

std::vector<Trajectory::Control> random_controls(std::uint64_t seed, int count) {
  egofocus::sim::Random random(seed);
  std::vector<Trajectory::Control> controls(static_cast<std::size_t>(count));
  for (Trajectory::Control& c : controls) {
    for (double& x : c.position) x = random.uniform(-2, 2);
    c.yaw = random.uniform(-3, 3);
    c.pitch = random.uniform(-1, 1);
    c.roll = random.uniform(-2, 2);
  }
  return controls;
}

/// The rotation vector of `m`, from its trace and its skew part.
Vec3 rotation_log(const Mat3& m) {
  const double cosine = (m[0][0] + m[1][1] + m[2][2] - 1) / 2;
  const double angle = std::acos(std::min(1.0, std::max(-1.0, cosine)));
  const double factor = angle < 1e-9 ? 0.5 : angle / (2 * std::sin(angle));
  return factor * Vec3{m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]};
}

double distance(const Vec3& a, const Vec3& b) {
  const Vec3 d = a - b;
  return std::sqrt(egofocus::sim::dot(d, d));
}

struct Errors {
  double velocity = 0;
  double rate = 0;
  double acceleration = 0;
  double rate_change = 0;
};

/// `state(t)` against central differences of its poses and rates.
template <typename State>
Errors errors_of(State state, double from_s, double to_s) {
  constexpr double h = 1e-4;
  Errors worst;
  for (double t = from_s; t < to_s; t += 0.0137) {
    const RigidState before = state(t - h);
    const RigidState now = state(t);
    const RigidState after = state(t + h);
    const Mat3 to_own = egofocus::sim::transpose(now.pose.rotation);
    const Vec3 velocity = (1 / (2 * h)) * (to_own * (after.pose.position - before.pose.position));
    const Vec3 acceleration =
        (1 / (h * h)) *
        (to_own * ((after.pose.position - now.pose.position) - (now.pose.position - before.pose.position)));
    const Mat3 turned = egofocus::sim::transpose(before.pose.rotation) * after.pose.rotation;
    const Vec3 rate = (1 / (2 * h)) * rotation_log(turned);
    const Vec3 rate_change = (1 / (2 * h)) * (after.rate_rad_s - before.rate_rad_s);
    worst.velocity = std::max(worst.velocity, distance(velocity, now.velocity_m_s));
    worst.rate = std::max(worst.rate, distance(rate, now.rate_rad_s));
    worst.acceleration = std::max(worst.acceleration, distance(acceleration, now.acceleration_m_s2));
    worst.rate_change = std::max(worst.rate_change, distance(rate_change, now.rate_change_rad_s2));
  }
  return worst;
}

}  // namespace

TEST_CASE("a trajectory's derivatives are those of its poses, for the body and for a camera on it") {
  const Trajectory trajectory(random_controls(3, 30), 0.5);
  REQUIRE(trajectory.duration_s() == Approx(13.5));
  const Mount mount{egofocus::sim::rotation({0.4, -1.1, 0.7}), {1.5, -0.3, 0.8}};
  const Errors body = errors_of([&](double t) { return trajectory.body_at(t); }, 0.01, 13.49);
  const Errors camera =
      errors_of([&](double t) { return camera_on(trajectory.body_at(t), mount); }, 0.01, 13.49);
  for (const Errors& errors : {body, camera}) {
    CHECK(errors.velocity < 1e-5);
    CHECK(errors.rate < 1e-5);
    CHECK(errors.acceleration < 2e-2);  // third derivatives jump at knots: h times the jump
    CHECK(errors.rate_change < 2e-2);
  }
  CHECK(distance(camera_on(trajectory.body_at(2), {}).velocity_m_s, trajectory.body_at(2).velocity_m_s) == 0);
}

TEST_CASE(
    "a trajectory begins at control point 1 of a straight line, and times beyond its ends are limited") {
  std::vector<Trajectory::Control> controls;
  for (int i = 0; i < 6; ++i) controls.push_back({{i * 1.0, 0, 0}, 0.1 * i, 0, 0});
  const Trajectory trajectory(controls, 0.5);
  REQUIRE(trajectory.duration_s() == Approx(1.5));
  CHECK(trajectory.body_at(0).pose.position[0] == Approx(1));
  CHECK(trajectory.body_at(1.5).pose.position[0] == Approx(4));
  CHECK(trajectory.body_at(9).pose.position[0] == Approx(4));
  CHECK(trajectory.body_at(-9).pose.position[0] == Approx(1));
  CHECK(trajectory.body_at(0.7).velocity_m_s[0] * std::cos(0.24) ==
        Approx(2 * std::cos(0.24) * std::cos(0.24)));
  CHECK(trajectory.body_at(0.7).rate_rad_s[2] == Approx(0.2));
  CHECK(trajectory.control_at(0.7).yaw == Approx(0.24));
}

TEST_CASE("positive pitch is nose down, positive roll is right side down") {
  const std::vector<Trajectory::Control> pitched(4, {{0, 0, 0}, 0, 0.2, 0});
  const Mat3 nose = Trajectory(pitched, 1).body_at(0).pose.rotation;
  CHECK(nose[2][0] == Approx(-std::sin(0.2)));  // the world's z of body x
  const std::vector<Trajectory::Control> rolled(4, {{0, 0, 0}, 0, 0, 0.2});
  const Mat3 side = Trajectory(rolled, 1).body_at(0).pose.rotation;
  CHECK(side[2][1] == Approx(std::sin(0.2)));  // of body y, the left
}

TEST_CASE("what an ideal IMU feels leads back to the trajectory") {
  for (const Robot robot : kRobots) {
    const Trajectory trajectory = move(robot, 10, 5);
    constexpr double h = 0.001;
    const RigidState start = trajectory.body_at(0);
    Mat3 rotation = start.pose.rotation;
    Vec3 position = start.pose.position;
    Vec3 velocity = rotation * start.velocity_m_s;
    for (int i = 0; i < 10000; ++i) {
      // The IMU's two outputs in the middle of the step; gravity is taken off in the integrated attitude.
      const RigidState now = trajectory.body_at((i + 0.5) * h);
      const Vec3 up = egofocus::sim::transpose(now.pose.rotation) * Vec3{0, 0, 1};
      const Vec3 force = now.acceleration_m_s2 + 9.8 * up;
      const Mat3 half = rotation * egofocus::sim::rotation((h / 2) * now.rate_rad_s);
      const Vec3 pull = half * force - Vec3{0, 0, 9.8};
      position = position + h * velocity + (0.5 * h * h) * pull;
      velocity = velocity + h * pull;
      rotation = rotation * egofocus::sim::rotation(h * now.rate_rad_s);
    }
    const RigidState end = trajectory.body_at(10);
    const double off_rad = distance(rotation_log(egofocus::sim::transpose(rotation) * end.pose.rotation), {});
    const double off_m = distance(position, end.pose.position);
    WARN(name_of(robot) << ": after 10 s of integration off by " << off_m << " m and " << off_rad << " rad");
    CHECK(off_rad < 1e-4);
    CHECK(off_m < 5e-3);
  }
}

TEST_CASE("control points that make no trajectory are refused") {
  std::vector<Trajectory::Control> controls(4);
  CHECK_NOTHROW(Trajectory(controls, 0.1));
  CHECK_THROWS_AS(Trajectory(controls, 0), std::invalid_argument);
  controls[2].pitch = 1.5;
  CHECK_THROWS_AS(Trajectory(controls, 0.1), std::invalid_argument);
  controls[2].pitch = 0;
  controls[1].position[2] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(Trajectory(controls, 0.1), std::invalid_argument);
  controls.resize(3);
  CHECK_THROWS_AS(Trajectory(controls, 0.1), std::invalid_argument);
}
