#include "citysim/drive.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "citysim/robots.hpp"

using namespace egofocus::citysim;
using namespace egofocus::citysim::test;

namespace {

constexpr double kDuration_s = 90;
constexpr Robot kWheeled[] = {Robot::kCar, Robot::kDelivery, Robot::kCorridor};

Ways ways_of(Robot robot) {
  return robot == Robot::kCar ? town_ways() : robot == Robot::kDelivery ? pavement_ways() : corridor_ways();
}

/// Distance from the route in the ground's plane, and the route's height there.
struct Nearest {
  double distance_m = 1e9;
  double z = 0;
};

Nearest nearest_on(const Route& route, const Vec3& p) {
  Nearest nearest;
  const std::size_t n = route.points.size();
  for (std::size_t i = 0; i + 1 < n + (route.closed ? 1 : 0); ++i) {
    const Vec3& a = route.points[i];
    const Vec3& b = route.points[(i + 1) % n];
    const double dx = b[0] - a[0];
    const double dy = b[1] - a[1];
    const double share = ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy);
    const double s = std::min(1.0, std::max(0.0, share));
    const double off = std::hypot(a[0] + s * dx - p[0], a[1] + s * dy - p[1]);
    if (off < nearest.distance_m) nearest = {off, a[2] + s * (b[2] - a[2])};
  }
  return nearest;
}

struct Figures {
  double sideways_rms_m_s = 0;
  double sideways_share = 0;  // rms of vy over rms of speed
  double top_speed_m_s = 0;
  double top_yaw_rate_rad_s = 0;
  double top_forward_m_s2 = 0;
  double standing_s = 0;
  int stops = 0;
  double way_m = 0;
  double off_route_m = 0;
  double off_height_m = 0;
  double rough_m_s2 = 0;  // rms of the vertical acceleration while driving
  double turned_in_place_rad = 0;
};

Figures figures_of(const Trajectory& trajectory, const Route& route) {
  constexpr double kStep_s = 0.01;
  Figures f;
  double sideways = 0;
  double speed2 = 0;
  double vertical = 0;
  int n = 0;
  int driving = 0;
  bool stood = false;
  for (double t = 0; t < kDuration_s; t += kStep_s, ++n) {
    const RigidState s = trajectory.body_at(t);
    const double speed = std::abs(s.velocity_m_s[0]);
    sideways += s.velocity_m_s[1] * s.velocity_m_s[1];
    speed2 += speed * speed;
    f.top_speed_m_s = std::max(f.top_speed_m_s, speed);
    f.top_yaw_rate_rad_s = std::max(f.top_yaw_rate_rad_s, std::abs(s.rate_rad_s[2]));
    f.top_forward_m_s2 = std::max(f.top_forward_m_s2, std::abs(s.acceleration_m_s2[0]));
    f.way_m += speed * kStep_s;
    const bool stands = speed < 1e-4;
    if (stands) f.standing_s += kStep_s;
    if (stands) f.turned_in_place_rad += std::abs(s.rate_rad_s[2]) * kStep_s;
    if (stands && !stood) ++f.stops;
    stood = stands;
    if (speed > 0.5) {
      vertical += s.acceleration_m_s2[2] * s.acceleration_m_s2[2];
      ++driving;
    }
    const Nearest nearest = nearest_on(route, s.pose.position);
    f.off_route_m = std::max(f.off_route_m, nearest.distance_m);
    f.off_height_m = std::max(f.off_height_m, std::abs(s.pose.position[2] - nearest.z));
  }
  f.sideways_rms_m_s = std::sqrt(sideways / n);
  f.sideways_share = std::sqrt(sideways / speed2);
  f.rough_m_s2 = std::sqrt(vertical / driving);
  return f;
}

}  // namespace

TEST_CASE("wheels do not move sideways, limits are kept, the route is not left") {
  for (const Robot robot : kWheeled) {
    double most_yaw_rate = 0;
    double turned_in_place = 0;
    int stops = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      const Ways ways = ways_of(robot);
      const Figures f = figures_of(move(robot, kDuration_s, seed), ways.route);
      WARN(name_of(robot) << " " << seed << ": " << f.way_m << " m, up to " << f.top_speed_m_s << " m/s, "
                          << f.top_yaw_rate_rad_s << " rad/s, " << f.top_forward_m_s2 << " m/s2; stood "
                          << f.standing_s << " s in " << f.stops << " stops; sideways "
                          << 1000 * f.sideways_rms_m_s << " mm/s rms, " << 100 * f.sideways_share
                          << " %; off the route " << f.off_route_m << " m, height " << f.off_height_m
                          << " m; rough " << f.rough_m_s2 << " m/s2");
      CHECK(f.sideways_rms_m_s < 0.05);
      CHECK(f.sideways_share < 0.01);
      CHECK(f.top_speed_m_s <= (robot == Robot::kCar ? 20.0 : robot == Robot::kDelivery ? 3.0 : 1.5));
      CHECK(f.top_yaw_rate_rad_s < (robot == Robot::kCar ? 0.8 : 1.6));
      CHECK(f.top_forward_m_s2 < (robot == Robot::kCar ? 4.5 : 2.5));
      CHECK(f.off_route_m <= ways.route.half_width_m);
      CHECK(f.off_height_m < 0.15);
      CHECK(f.way_m > (robot == Robot::kCar ? 150 : 20));
      CHECK(f.rough_m_s2 > 0.01);
      CHECK(f.rough_m_s2 < 2.5);
      most_yaw_rate = std::max(most_yaw_rate, f.top_yaw_rate_rad_s);
      turned_in_place += f.turned_in_place_rad;
      stops += f.stops;
    }
    CHECK(most_yaw_rate > (robot == Robot::kCar ? 0.4 : 1.0));
    CHECK(stops >= 8);
    CHECK((turned_in_place > 1) == (robot != Robot::kCar));
  }
}

TEST_CASE("narrow streets are not left in corners of any angle") {
  Ways ways;
  ways.route.points = {{0, 0, 0}, {60, 0, 0}, {60, 60, 0}, {0, 90, 0}, {60, 130, 0}, {60, 200, 0}};
  ways.route.speed_limit_m_s = {10, 10, 10, 10, 10, 10};
  ways.route.half_width_m = 0.8;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Figures f =
        figures_of(drive(ways, drive_style(Vehicle::kCar, seed), kDuration_s, seed), ways.route);
    CHECK(f.off_route_m <= 0.8);
    CHECK(f.off_route_m > 0.3);
    CHECK(f.way_m > 130);
  }
}

TEST_CASE("a car brakes nose down and leans out of a turn") {
  Ways ways;
  ways.route.points = {{0, 0, 0}, {100, 0, 0}, {100, 100, 0}, {0, 100, 0}};
  ways.route.speed_limit_m_s = {15, 15, 15, 15};
  ways.route.half_width_m = 6;
  ways.route.closed = true;
  DriveStyle style;
  style.heave_m_s = 0;
  style.rock_rad_s = 0;
  const Trajectory trajectory = drive(ways, style, 60, 7);
  double braking = 0;
  double turning = 0;
  int braked = 0;
  int turned = 0;
  for (double t = 0; t < 60; t += 0.05) {
    const RigidState s = trajectory.body_at(t);
    const Trajectory::Control c = trajectory.control_at(t);
    if (s.acceleration_m_s2[0] < -2) braking += c.pitch, ++braked;
    if (s.acceleration_m_s2[1] > 1.5) turning += c.roll, ++turned;
  }
  REQUIRE(braked > 10);
  REQUIRE(turned > 10);
  CHECK(braking / braked > 0.006);
  CHECK(turning / turned > 0.01);
}

TEST_CASE("at the end of an open route a car stands, a robot comes back; a closed one goes round") {
  Ways ways;
  ways.route.points = {{0, 0, 0}, {40, 0, 0}};
  ways.route.speed_limit_m_s = {10, 10};
  const Trajectory car = drive(ways, drive_style(Vehicle::kCar, 1), 60, 1);
  CHECK(car.body_at(60).pose.position[0] == Approx(40).margin(0.01));
  CHECK(std::abs(car.body_at(60).velocity_m_s[0]) < 1e-6);

  ways.route.points = {{0, 0, 0}, {12, 0, 0}};
  DriveStyle style = drive_style(Vehicle::kDeliveryRobot, 1);
  style.stop_every_m = 0;
  const Trajectory robot = drive(ways, style, 40, 1);
  double farthest = 0;
  double back = 12;
  for (double t = 0; t < 40; t += 0.1) {
    const double x = robot.body_at(t).pose.position[0];
    farthest = std::max(farthest, x);
    if (farthest > 11.9) back = std::min(back, x);
  }
  CHECK(farthest > 11.9);
  CHECK(back < 6);

  DriveStyle racing = drive_style(Vehicle::kCar, 1);
  racing.stop_every_m = 0;
  const Trajectory round = drive(town_ways(), racing, 300, 3);
  CHECK(round.control_at(300).yaw > 6.3);  // more than once around, always to the left in the end
}

TEST_CASE("the same seed drives the same way, another one another") {
  const Trajectory a = move(Robot::kCar, 20, 4);
  const Trajectory b = move(Robot::kCar, 20, 4);
  const Trajectory c = move(Robot::kCar, 20, 5);
  CHECK(a.body_at(17).pose.position == b.body_at(17).pose.position);
  CHECK(a.body_at(17).pose.position != c.body_at(17).pose.position);
}

TEST_CASE("routes that cannot be driven are refused") {
  const DriveStyle style = drive_style(Vehicle::kCar, 1);
  Ways ways;
  ways.route.points = {{0, 0, 0}};
  ways.route.speed_limit_m_s = {10};
  CHECK_THROWS_AS(drive(ways, style, 10, 1), std::invalid_argument);
  ways.route.points.push_back({0, 0, 1});
  ways.route.speed_limit_m_s = {10, 10};
  CHECK_THROWS_AS(drive(ways, style, 10, 1), std::invalid_argument);
  ways.route.points[1] = {30, 0, 0};
  CHECK_NOTHROW(drive(ways, style, 10, 1));
  CHECK_THROWS_AS(drive(ways, style, 0, 1), std::invalid_argument);
  CHECK_THROWS_AS(drive(ways, style, 2000, 1), std::invalid_argument);
  ways.route.speed_limit_m_s = {10, 0};
  CHECK_THROWS_AS(drive(ways, style, 10, 1), std::invalid_argument);
  ways.route.speed_limit_m_s = {10};
  CHECK_THROWS_AS(drive(ways, style, 10, 1), std::invalid_argument);
  ways.route.points.push_back({1, 0.5, 0});
  ways.route.speed_limit_m_s = {10, 10, 10};
  CHECK_THROWS_AS(drive(ways, style, 10, 1), std::invalid_argument);  // a hairpin
}
