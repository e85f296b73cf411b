#include <algorithm>
#include <stdexcept>

#include "citysim/fly.hpp"
#include "citysim/free_space.hpp"
#include "citysim/random.hpp"
#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

using sim::Random;

constexpr double kStep_s = 0.02;
constexpr double kLeastStroke_m = 0.04;
constexpr double kHardest_m_s2 = 1.5;  // mean over a ramp; its peak is half as much again

/// From rest to rest: a straight way, or an arc about a vertical line through `centre`.
struct Stroke {
  Vec3 from{0, 0, 0};
  Vec3 way{0, 0, 0};     // straight
  Vec3 centre{0, 0, 0};  // arc
  double turn = 0;       // arc, rad; 0: straight
  double length = 0;     // m

  [[nodiscard]] Vec3 at(double share) const {
    if (turn == 0) return from + share * way;
    const double s = sine(share * turn);
    const double c = cosine(share * turn);
    const double x = from[0] - centre[0];
    const double y = from[1] - centre[1];
    return {centre[0] + c * x - s * y, centre[1] + s * x + c * y, from[2]};
  }
};

/// How far one can go from `point` along the unit vector `way`, inside the box.
double room(const FreeBox& box, const Vec3& point, const Vec3& way) {
  double most = 1e9;
  for (std::size_t i = 0; i < 3; ++i) {
    if (way[i] > 1e-9) most = std::min(most, (box.high[i] - point[i]) / way[i]);
    if (way[i] < -1e-9) most = std::min(most, (box.low[i] - point[i]) / way[i]);
  }
  return most;
}

/// Sideways, forward, or mixed, as the body looks.
Vec3 stroke_direction(double yaw, Random& random) {
  const Vec3 forward{cosine(yaw), sine(yaw), 0};
  const Vec3 left{-forward[1], forward[0], 0};
  const Vec3 up{0, 0, 1};
  const double dice = random.uniform();
  if (dice < 0.4) return left;
  if (dice < 0.6) return forward;
  if (dice < 0.7) return up;
  const double ahead = random.uniform(-1, 1);
  const double aside = random.uniform(0.1, 1);
  const double rise = random.uniform(-0.5, 0.5);
  const Vec3 mixed = ahead * forward + aside * left + rise * up;
  return (1 / square_root(sim::dot(mixed, mixed))) * mixed;
}

bool straight_stroke(const FreeBox& box, double yaw, Random& random, Stroke& stroke) {
  const Vec3 direction = stroke_direction(yaw, random);
  const Vec3 back = -1.0 * direction;
  const double ahead_m = room(box, stroke.from, direction);
  const double back_m = room(box, stroke.from, back);
  stroke.turn = 0;
  stroke.length = random.uniform(0.7, 1.0) * std::max(ahead_m, back_m);
  stroke.way = stroke.length * (ahead_m > back_m ? direction : back);
  return stroke.length >= kLeastStroke_m;
}

bool orbit_stroke(const FreeBox& box, const Vec3& sight, Random& random, Stroke& stroke) {
  stroke.centre = sight;
  const bool leftwards = random.chance(0.5);
  stroke.turn = random.uniform(0.2, 1.2) * (leftwards ? 1 : -1);
  const double x = stroke.from[0] - sight[0];
  const double y = stroke.from[1] - sight[1];
  stroke.length = absolute(stroke.turn) * square_root(x * x + y * y);
  constexpr int kSamples = 64;
  for (int i = 0; i <= kSamples; ++i) {
    if (!contains(box, stroke.at(static_cast<double>(i) / kSamples))) return false;
  }
  return stroke.length >= kLeastStroke_m;
}

/// Share of a way from rest to rest that is done after t: speed ramps up and down like 3 u^2 - 2 u^3.
double share_done(double t, double ramp_s, double total_s) {
  const double cruise_s = total_s - ramp_s;
  const auto ramped = [&](double into_s) {
    const double u = clamped(0, into_s / ramp_s, 1);
    return ramp_s * (u * u * u - 0.5 * u * u * u * u) + std::max(0.0, into_s - ramp_s);
  };
  if (2 * t <= total_s) return ramped(t) / cruise_s;
  return 1 - ramped(total_s - t) / cruise_s;
}

}  // namespace

SlideStyle slide_style(bool arm, std::uint64_t seed) {
  Random random(seed, "slide style");
  SlideStyle style;
  style.arm = arm;
  style.max_speed_m_s = random.uniform(0.7, 1.0);
  style.ramp_s = random.uniform(0.25, 0.5);
  if (arm) style.max_roll_rad = 0.6;
  return style;
}

Trajectory slide(const Ways& ways, const SlideStyle& style, double duration_s, std::uint64_t seed) {
  if (!(duration_s > 0 && duration_s <= 1000)) throw std::invalid_argument("a slide lasts up to 1000 s");
  Random random(seed, "slide plan");
  const std::vector<FreeBox> boxes = inner_boxes(ways, 0.02);
  const FreeBox& box = boxes[random.below(static_cast<std::uint32_t>(boxes.size()))];
  const Vec3 sight = ways.sights[random.below(static_cast<std::uint32_t>(ways.sights.size()))];
  Vec3 position = random_point(box, random);
  const Heading aim = heading_to(position, sight, 0);
  double yaw = aim.yaw + 0.5 * style.max_tilt_rad * random.uniform(-1, 1);
  const double pitch = clamped(-1.2, aim.pitch + style.max_tilt_rad * random.uniform(-1, 1), 1.2);
  const double roll = style.max_roll_rad * random.uniform(-1, 1);

  const std::size_t wanted = static_cast<std::size_t>(duration_s / kStep_s + 0.999999) + 3;
  std::vector<Trajectory::Control> controls;
  const auto rest = [&](double for_s) {
    for (double t = 0; t < for_s; t += kStep_s) controls.push_back({position, yaw, pitch, roll});
  };
  rest(random.uniform(0.1, 1.0));
  while (controls.size() < wanted) {
    Stroke stroke;
    stroke.from = position;
    bool found = style.arm && random.chance(0.4) && orbit_stroke(box, sight, random, stroke);
    for (int i = 0; i < 8 && !found; ++i) found = straight_stroke(box, yaw, random, stroke);
    if (!found) {
      stroke.turn = 0;
      stroke.way = random_point(box, random) - position;
      stroke.length = square_root(sim::dot(stroke.way, stroke.way)) + 1e-6;
    }
    double speed = random.uniform(style.min_speed_m_s, style.max_speed_m_s);
    if (random.chance(0.07)) speed = style.min_speed_m_s * random.uniform(0.33, 1.0);
    speed = std::min({speed, 0.8 * stroke.length / style.ramp_s, kHardest_m_s2 * style.ramp_s});
    if (stroke.turn != 0)
      speed = std::min(speed, style.max_rate_rad_s * stroke.length / absolute(stroke.turn));
    const double total_s = stroke.length / speed + style.ramp_s;
    for (double t = 0; t < total_s; t += kStep_s) {
      const double share = share_done(t, style.ramp_s, total_s);
      controls.push_back({stroke.at(share), yaw + share * stroke.turn, pitch, roll});
    }
    position = stroke.at(1);
    yaw += stroke.turn;
    rest(random.chance(0.3) ? random.uniform(0.1, 0.7) : 0.0);
  }
  controls.resize(wanted);
  return {std::move(controls), kStep_s};
}

}  // namespace egofocus::citysim
