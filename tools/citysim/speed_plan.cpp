#include "citysim/speed_plan.hpp"

#include <algorithm>

#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

using sim::Random;
using Node = DrivePath::Node;

/// A stay at one node.
struct Stop {
  std::size_t node = 0;
  double for_s = 0;
};

/// Where the robot stands: at its start (perhaps), at traffic lights, before and after a turn on the spot.
std::vector<Stop> stops_of(const DrivePath& path, const DriveStyle& style, Random& random) {
  const std::vector<Node>& nodes = path.nodes();
  const double settle_s = 2 * style.smoothing_s;  // smoothing eats that much of a stop
  std::vector<Stop> stops;
  if (random.chance(style.start_standing)) stops.push_back({0, settle_s + random.uniform(0.8, 2.0)});
  double next = style.stop_every_m > 0 ? style.stop_every_m * random.uniform(0.3, 1.2) : path.length() + 1;
  for (std::size_t i = 1; i + 2 < nodes.size(); ++i) {
    // From a stop at one node to a stop at the next there is no way.
    const bool alone =
        nodes[i + 1].in_place == nodes[i].in_place && (stops.empty() || stops.back().node + 1 < i);
    if (nodes[i].in_place != nodes[i - 1].in_place) {
      stops.push_back({i, settle_s + random.uniform(0.05, 0.5)});
    } else if (nodes[i].progress > next && nodes[i].may_stop && alone) {
      stops.push_back({i, settle_s + random.uniform(1.0, 4.0)});
      next = nodes[i].progress + style.stop_every_m * random.uniform(0.4, 1.6);
    }
  }
  return stops;
}

/// Squared speed at each node. Each piece of the path has its mood: how much of the limits is used.
std::vector<double> speeds_of(const DrivePath& path, const DriveStyle& style, const std::vector<Stop>& stops,
                              Random& random) {
  const std::vector<Node>& nodes = path.nodes();
  const std::size_t n = nodes.size();
  std::vector<double> squared(n);
  std::vector<double> vigour(n);
  double mood = 1;
  double pull = 1;
  for (std::size_t i = 0; i < n; ++i) {
    if (i == 0 || nodes[i].piece != nodes[i - 1].piece) {
      mood = 1 - style.hesitation * random.uniform();
      pull = random.uniform(0.5, 1);
    }
    vigour[i] = pull;
    double limit = mood * std::min(nodes[i].speed_limit, style.max_speed_m_s);
    const double turn = absolute(nodes[i].turn_per_progress);
    if (nodes[i].in_place) {
      limit = mood * style.max_yaw_rate_rad_s / (turn + 0.1);
    } else if (turn > 0) {
      limit = std::min({limit, style.max_yaw_rate_rad_s / turn, square_root(style.lateral_m_s2 / turn)});
    }
    squared[i] = limit * limit;
  }
  squared[n - 1] = 0;
  for (const Stop& stop : stops) squared[stop.node] = 0;
  for (std::size_t i = n - 1; i-- > 0;) {
    const double way = nodes[i + 1].progress - nodes[i].progress;
    squared[i] = std::min(squared[i], squared[i + 1] + 2 * vigour[i] * style.braking_m_s2 * way);
  }
  // Engines pull less the faster they turn.
  const double top2 = style.max_speed_m_s * style.max_speed_m_s;
  for (std::size_t i = 1; i < n; ++i) {
    const double way = nodes[i].progress - nodes[i - 1].progress;
    const double force = vigour[i] * (1 - 0.6 * std::min(1.0, squared[i - 1] / top2));
    squared[i] = std::min(squared[i], squared[i - 1] + 2 * force * style.acceleration_m_s2 * way);
  }
  return squared;
}

}  // namespace

std::vector<double> smoothed(const std::vector<double>& values, std::size_t half) {
  std::vector<double> now = values;
  const std::size_t n = values.size();
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<double> before = now;
    const auto held = [&](std::size_t i) { return before[i < half ? 0 : std::min(i - half, n - 1)]; };
    double sum = 0;
    for (std::size_t k = 0; k < 2 * half; ++k) sum += held(k);
    for (std::size_t i = 0; i < n; ++i) {
      sum += held(i + 2 * half);
      now[i] = sum / static_cast<double>(2 * half + 1);
      sum -= held(i);
    }
  }
  return now;
}

std::vector<double> plan_progress(const DrivePath& path, const DriveStyle& style, double step_s,
                                  double lead_s, std::size_t count, sim::Random& random) {
  const std::vector<Node>& nodes = path.nodes();
  const std::vector<Stop> stops = stops_of(path, style, random);
  const std::vector<double> squared = speeds_of(path, style, stops, random);
  std::vector<double> progress(count);
  // Of the robot's stay or way at node `cell`. Who does not begin with a stay is at speed when time 0 comes.
  double begin_s = !stops.empty() && stops.front().node == 0 ? 0 : -lead_s;
  std::size_t cell = 0;
  auto stop = stops.begin();
  const auto stay = [&] { return stop != stops.end() && stop->node == cell ? stop->for_s : 0.0; };
  const auto cell_s = [&] {
    const double way = nodes[cell + 1].progress - nodes[cell].progress;
    return 2 * way / (square_root(squared[cell]) + square_root(squared[cell + 1]));
  };
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) * step_s - lead_s;
    while (cell + 1 < nodes.size() && t >= begin_s + stay() + cell_s()) {
      begin_s += stay() + cell_s();
      if (stop != stops.end() && stop->node == cell) ++stop;
      ++cell;
    }
    const double into = t - begin_s - stay();
    progress[i] = nodes[cell].progress;
    if (into <= 0 || cell + 1 == nodes.size()) continue;
    const double way = nodes[cell + 1].progress - nodes[cell].progress;
    const double pull = (squared[cell + 1] - squared[cell]) / (2 * way);
    progress[i] += into * (square_root(squared[cell]) + 0.5 * pull * into);
  }
  return smoothed(progress, static_cast<std::size_t>(style.smoothing_s / (2 * step_s)));
}

}  // namespace egofocus::citysim
