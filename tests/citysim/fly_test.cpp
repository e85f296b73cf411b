#include "citysim/fly.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "citysim/robots.hpp"

using namespace egofocus::citysim;
using namespace egofocus::citysim::test;

namespace {

constexpr double kDuration_s = 120;

double length(const Vec3& v) {
  return std::sqrt(egofocus::sim::dot(v, v));
}

/// How deep `p` lies inside the best of the boxes; negative outside.
double depth_inside(const std::vector<FreeBox>& boxes, const Vec3& p) {
  double best = -1e9;
  for (const FreeBox& box : boxes) {
    double depth = 1e9;
    for (std::size_t i = 0; i < 3; ++i) depth = std::min({depth, p[i] - box.low[i], box.high[i] - p[i]});
    best = std::max(best, depth);
  }
  return best;
}

struct Figures {
  double least_depth_m = 1e9;
  double top_speed_m_s = 0;
  double top_rate_rad_s = 0;
  double top_acceleration_m_s2 = 0;
  double most_roll_rad = 0;
  double moving_s = 0;   // above 0.2 m/s
  double turning_s = 0;  // above 0.3 rad/s, below 0.05 m/s
  double dead_still_s = 0;
  double trembling_s = 0;  // below 0.05 m/s, but not dead still
  bool both_boxes = false;
  double looking = 0;  // share of the time in which some sight is within 35 degrees of body x
};

Figures figures_of(const Trajectory& trajectory, const Ways& ways) {
  constexpr double kStep_s = 0.005;
  Figures f;
  bool first = false;
  bool second = false;
  int n = 0;
  int looks = 0;
  for (double t = 0; t < kDuration_s; t += kStep_s, ++n) {
    const RigidState s = trajectory.body_at(t);
    const Vec3& p = s.pose.position;
    const double speed = length(s.velocity_m_s);
    const double rate = length(s.rate_rad_s);
    f.least_depth_m = std::min(f.least_depth_m, depth_inside(ways.boxes, p));
    f.top_speed_m_s = std::max(f.top_speed_m_s, speed);
    f.top_rate_rad_s = std::max(f.top_rate_rad_s, rate);
    f.top_acceleration_m_s2 = std::max(f.top_acceleration_m_s2, length(s.acceleration_m_s2));
    f.most_roll_rad = std::max(f.most_roll_rad, std::abs(trajectory.control_at(t).roll));
    if (speed > 0.2) f.moving_s += kStep_s;
    if (speed < 0.05 && rate > 0.3) f.turning_s += kStep_s;
    const bool dead = speed < 1e-9 && rate < 1e-9;
    if (dead) f.dead_still_s += kStep_s;
    if (speed < 0.05 && !dead) f.trembling_s += kStep_s;
    first = first || depth_inside({ways.boxes.front()}, p) > 0.2;
    second = second || depth_inside({ways.boxes.back()}, p) > 0.2;
    bool looks_at = false;
    for (const Vec3& sight : ways.sights) {
      const Vec3 way = egofocus::sim::transpose(s.pose.rotation) * (sight - p);
      looks_at = looks_at || way[0] > 0.82 * length(way);
    }
    if (looks_at) ++looks;
  }
  f.both_boxes = first && second;
  f.looking = static_cast<double>(looks) / n;
  return f;
}

}  // namespace

TEST_CASE("hands and drones stay in their boxes and do everything in turn") {
  for (const Robot robot : {Robot::kHand, Robot::kDrone}) {
    Figures sum;
    int both_boxes = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const Figures f = figures_of(move(robot, kDuration_s, seed), room_ways());
      WARN(name_of(robot) << " " << seed << ": deepest to the side " << f.least_depth_m << " m, up to "
                          << f.top_speed_m_s << " m/s, " << f.top_rate_rad_s << " rad/s, "
                          << f.top_acceleration_m_s2 << " m/s2, roll " << f.most_roll_rad << "; moves "
                          << f.moving_s << " s, turns " << f.turning_s << " s, trembles " << f.trembling_s
                          << " s, dead still " << f.dead_still_s << " s; looks at sights " << f.looking);
      CHECK(f.least_depth_m > 0.14);
      CHECK(f.top_speed_m_s < 4.2);
      CHECK(f.top_rate_rad_s < 2.3);
      CHECK(f.top_acceleration_m_s2 < 9);
      CHECK(f.most_roll_rad < 0.6);
      CHECK(f.moving_s > 20);
      CHECK(f.looking > 0.5);
      sum.turning_s += f.turning_s;
      sum.trembling_s += f.trembling_s;
      sum.dead_still_s += f.dead_still_s;
      sum.top_rate_rad_s = std::max(sum.top_rate_rad_s, f.top_rate_rad_s);
      sum.top_speed_m_s = std::max(sum.top_speed_m_s, f.top_speed_m_s);
      sum.most_roll_rad = std::max(sum.most_roll_rad, f.most_roll_rad);
      if (f.both_boxes) ++both_boxes;
    }
    CHECK(both_boxes >= 3);
    CHECK(sum.turning_s > 10);
    CHECK(sum.trembling_s > 10);
    CHECK((sum.dead_still_s > 2) == (robot == Robot::kHand));
    CHECK(sum.top_rate_rad_s > 1.0);
    CHECK(sum.top_speed_m_s > 0.8);
    CHECK(sum.most_roll_rad > 0.25);
  }
}

TEST_CASE("around a corner from box to box no corner is cut") {
  Ways ways;
  ways.boxes = {{{0, 0, 0}, {6, 0.15, 2}}, {{5.85, 0, 0}, {6, 6, 2}}};
  ways.sights = {{3, 3, 1}, {8, 3, 1}, {3, -2, 1}};
  FlyStyle style;
  style.margin_m = 0;
  style.tremor_m_s = 0;
  style.min_speed_m_s = 1;
  style.max_speed_m_s = 3;
  style.max_acceleration_m_s2 = 6;
  int crossed = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Trajectory trajectory = fly(ways, style, kDuration_s, seed);
    double least_depth_m = 1e9;
    bool first = false;
    bool second = false;
    for (double t = 0; t < kDuration_s; t += 0.005) {
      const Vec3 p = trajectory.body_at(t).pose.position;
      least_depth_m = std::min(least_depth_m, depth_inside(ways.boxes, p));
      first = first || p[0] < 5;
      second = second || p[1] > 1;
    }
    CHECK(least_depth_m > -1e-9);
    if (first && second) ++crossed;
  }
  CHECK(crossed >= 10);
}

TEST_CASE("sliders and arms stay in their box, stroke after stroke") {
  for (const Robot robot : {Robot::kSlider, Robot::kArm}) {
    double turned_s = 0;
    double top_speed = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const Ways ways = desk_ways();
      const Trajectory trajectory = move(robot, kDuration_s, seed);
      const Figures f = figures_of(trajectory, ways);
      WARN(name_of(robot) << " " << seed << ": deepest to the side " << f.least_depth_m << " m, up to "
                          << f.top_speed_m_s << " m/s, " << f.top_rate_rad_s << " rad/s, dead still "
                          << f.dead_still_s << " s");
      CHECK(f.least_depth_m > 0.019);
      CHECK(f.top_speed_m_s < 1.02);
      CHECK(f.top_rate_rad_s < 0.9);
      CHECK(f.top_acceleration_m_s2 < 8);
      CHECK(f.dead_still_s > 1);
      double sideways_s = 0;
      double forward_s = 0;
      for (double t = 0; t < kDuration_s; t += 0.02) {
        const RigidState s = trajectory.body_at(t);
        if (length(s.rate_rad_s) > 0.02) turned_s += 0.02;
        if (std::abs(s.velocity_m_s[1]) > 0.04) sideways_s += 0.02;
        if (std::abs(s.velocity_m_s[0]) > 0.04) forward_s += 0.02;
      }
      CHECK(sideways_s > 10);
      CHECK(forward_s > 5);
      top_speed = std::max(top_speed, f.top_speed_m_s);
    }
    CHECK((turned_s > 5) == (robot == Robot::kArm));
    CHECK(top_speed > 0.6);
  }
}

TEST_CASE("the same seed flies and slides the same way") {
  for (const Robot robot : {Robot::kHand, Robot::kDrone, Robot::kSlider, Robot::kArm}) {
    CHECK(move(robot, 20, 4).body_at(17).pose.position == move(robot, 20, 4).body_at(17).pose.position);
    CHECK(move(robot, 20, 4).body_at(17).pose.position != move(robot, 20, 5).body_at(17).pose.position);
  }
}

TEST_CASE("ways without boxes or sights are refused") {
  Ways ways = room_ways();
  ways.sights.clear();
  CHECK_THROWS_AS(fly(ways, {}, 10, 1), std::invalid_argument);
  CHECK_THROWS_AS(slide(ways, {}, 10, 1), std::invalid_argument);
  ways = room_ways();
  CHECK_THROWS_AS(fly(ways, {}, 0, 1), std::invalid_argument);
  CHECK_THROWS_AS(slide(ways, {}, 1e6, 1), std::invalid_argument);
  ways.boxes[1].high[2] = ways.boxes[1].low[2];
  CHECK_THROWS_AS(fly(ways, {}, 10, 1), std::invalid_argument);
  ways.boxes.clear();
  CHECK_THROWS_AS(fly(ways, {}, 10, 1), std::invalid_argument);
}
