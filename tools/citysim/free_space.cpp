#include "citysim/free_space.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/elementary.hpp"

namespace egofocus::citysim {

using sim::Vec3;

std::vector<FreeBox> inner_boxes(const Ways& ways, double margin_m) {
  if (ways.boxes.empty()) throw std::invalid_argument("there is no free box to move in");
  if (ways.sights.empty()) throw std::invalid_argument("there is no sight to look at");
  std::vector<FreeBox> boxes = ways.boxes;
  for (FreeBox& box : boxes) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double side = box.high[i] - box.low[i];
      if (!(side > 0)) throw std::invalid_argument("a free box has no volume");
      const double in = std::min(margin_m, 0.3 * side);
      box.low[i] += in;
      box.high[i] -= in;
    }
  }
  return boxes;
}

bool shared_part(const FreeBox& a, const FreeBox& b, FreeBox& shared) {
  constexpr double kLeastSide_m = 0.02;
  for (std::size_t i = 0; i < 3; ++i) {
    shared.low[i] = std::max(a.low[i], b.low[i]);
    shared.high[i] = std::min(a.high[i], b.high[i]);
    if (shared.high[i] - shared.low[i] < kLeastSide_m) return false;
  }
  return true;
}

Vec3 random_point(const FreeBox& box, sim::Random& random) {
  const double x = random.uniform(box.low[0], box.high[0]);
  const double y = random.uniform(box.low[1], box.high[1]);
  const double z = random.uniform(box.low[2], box.high[2]);
  return {x, y, z};
}

Vec3 limited_to(const FreeBox& box, const Vec3& point) {
  Vec3 out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = clamped(box.low[i], point[i], box.high[i]);
  return out;
}

bool contains(const FreeBox& box, const Vec3& point) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(point[i] >= box.low[i] && point[i] <= box.high[i])) return false;
  }
  return true;
}

Heading heading_to(const Vec3& from, const Vec3& sight, double near_yaw) {
  constexpr double kTwoPi = 6.28318530717958647692;
  const Vec3 way = sight - from;
  const double yaw = arc_tangent2(way[1], way[0]);
  const double turns = floor_of((near_yaw - yaw) / kTwoPi + 0.5);
  return {yaw + turns * kTwoPi, -arc_tangent2(way[2], square_root(way[0] * way[0] + way[1] * way[1]))};
}

}  // namespace egofocus::citysim
