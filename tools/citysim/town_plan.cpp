#include "citysim/town_plan.hpp"

#include <algorithm>

namespace egofocus::citysim {
namespace {

constexpr double kTurn = 6.283185307179586;
constexpr int kDx[4] = {1, 0, -1, 0};  // east, north, west, south
constexpr int kDy[4] = {0, 1, 0, -1};

}  // namespace

TownPlan::TownPlan(const TownStyle& style, double way_m, Random& random)
    : bend_m_(random.uniform(0.5, 2.5)),
      wave_m_(random.uniform(0.1, 0.5)),
      slope_x_(style.slope * random.uniform(-1, 1)),
      slope_y_(style.slope * random.uniform(-1, 1)),
      bend_length_m_(random.uniform(200, 320)) {
  for (double& phase : phase_) phase = random.uniform(0, kTurn);
  for (std::vector<double>* axis : {&xs_, &ys_}) {
    double at = 0;
    for (int i = 0; i < kSide; ++i) {
      axis->push_back(at);
      at += style.block_m * random.uniform(0.7, 1.4);
    }
  }
  Crossing at{kSide / 2, kSide / 2};
  int heading = static_cast<int>(random.below(4));
  way_.push_back(at);
  for (double length = 0; length < way_m;) {
    // Straight on, or a turn; never off the lattice's edge.
    int next = heading;
    for (int tries = 0;; ++tries) {
      next = random.chance(0.5) ? heading : (heading + (random.chance(0.5) ? 1 : 3)) % 4;
      const int x = at.first + kDx[next];
      const int y = at.second + kDy[next];
      if ((x >= 2 && x < kSide - 2 && y >= 2 && y < kSide - 2) || tries > 20) break;
    }
    heading = next;
    const Crossing to{std::clamp(at.first + kDx[heading], 1, kSide - 2),
                      std::clamp(at.second + kDy[heading], 1, kSide - 2)};
    length +=
        absolute(column_x(to.first) - column_x(at.first)) + absolute(row_y(to.second) - row_y(at.second));
    travelled_.insert({at, to});
    at = to;
    way_.push_back(at);
  }
  for (const Crossing& crossing : way_) {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) built_.insert({crossing.first + dx, crossing.second + dy});
    }
  }
}

Vec3 TownPlan::ground(double x, double y, double above) const {
  const double k = kTurn / bend_length_m_;
  return {
      x + bend_m_ * sine(k * y + phase_[0]), y + bend_m_ * sine(k * x + phase_[1]),
      slope_x_ * x + slope_y_ * y + wave_m_ * (sine(k * x + phase_[2]) + sine(k * y + phase_[3])) + above};
}

Place TownPlan::place(double x, double y, double angle) const {
  const double c = cosine(angle);
  const double s = sine(angle);
  Vec3 along = ground(x + 0.5 * c, y + 0.5 * s) - ground(x - 0.5 * c, y - 0.5 * s);
  along[2] = 0;
  along = (1.0 / square_root(dot(along, along))) * along;
  return {ground(x, y), along, cross({0, 0, 1}, along), {0, 0, 1}};
}

Route TownPlan::route(double right_m, double speed_limit_m_s) const {
  Route route;
  route.half_width_m = 1.2;
  std::vector<std::pair<double, double>> corners;
  const auto heading = [&](std::size_t i) {
    const double dx = way_[i + 1].first - way_[i].first;
    const double dy = way_[i + 1].second - way_[i].second;
    return std::pair{dx, dy};
  };
  for (std::size_t i = 0; i < way_.size(); ++i) {
    const auto [ax, ay] = heading(i > 0 ? i - 1 : 0);
    const auto [bx, by] = heading(i + 1 < way_.size() ? i : i - 1);
    double x = column_x(way_[i].first);
    double y = row_y(way_[i].second);
    const bool straight = ax == bx && ay == by;
    // Right of (dx, dy) is (dy, -dx).
    x += right_m * (straight ? ay : ay + by);
    y -= right_m * (straight ? ax : ax + bx);
    corners.emplace_back(x, y);
  }
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const auto [ax, ay] = corners[i];
    const auto [bx, by] = corners[i + 1];
    const double length = absolute(bx - ax) + absolute(by - ay);
    const int pieces = std::max(1, static_cast<int>(length / 6.0));
    for (int k = 0; k < pieces; ++k) {
      const double f = static_cast<double>(k) / pieces;
      route.points.push_back(ground(ax + f * (bx - ax), ay + f * (by - ay)));
      route.speed_limit_m_s.push_back(speed_limit_m_s);
    }
  }
  route.points.push_back(ground(corners.back().first, corners.back().second));
  route.speed_limit_m_s.push_back(speed_limit_m_s);
  return route;
}

}  // namespace egofocus::citysim
