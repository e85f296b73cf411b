// Boxes that a camera may be in: what fly and slide ask of them.
#pragma once

#include <vector>

#include "citysim/random.hpp"
#include "citysim/ways.hpp"

namespace egofocus::citysim {

/// The boxes and sights, checked and drawn in from the sides: by `margin_m`, but never by more than 30 % of a
/// side. Throws std::invalid_argument without boxes or sights, or for a box without volume.
[[nodiscard]] std::vector<FreeBox> inner_boxes(const Ways& ways, double margin_m);

/// The part that two boxes share; false if there is none, or less than 2 cm of a side.
[[nodiscard]] bool shared_part(const FreeBox& a, const FreeBox& b, FreeBox& shared);

[[nodiscard]] sim::Vec3 random_point(const FreeBox& box, sim::Random& random);
/// The nearest point of the box.
[[nodiscard]] sim::Vec3 limited_to(const FreeBox& box, const sim::Vec3& point);
[[nodiscard]] bool contains(const FreeBox& box, const sim::Vec3& point);

/// Where body x must look.
struct Heading {
  double yaw = 0;
  double pitch = 0;  ///< positive: down
};
/// The yaw is the one nearest to `near_yaw`, not wrapped.
[[nodiscard]] Heading heading_to(const sim::Vec3& from, const sim::Vec3& sight, double near_yaw);

[[nodiscard]] inline double clamped(double low, double value, double high) {
  return value < low ? low : value > high ? high : value;
}

}  // namespace egofocus::citysim
