// A stretch of a town's street, and what stands and moves along it.
#pragma once

#include "citysim/town_plan.hpp"

namespace egofocus::citysim {

inline constexpr double kKerb_m = 0.12;  ///< pavements lie so much above the road

/// A stretch of street from crossing to crossing: s runs along it, d to its left, 0 at its middle.
struct Street {
  const TownPlan& plan;
  bool along_x;
  double fixed;  ///< the middle's other coordinate
  double from, to;
  bool free_along = true;    ///< the robot's way does not go along it
  bool free_against = true;  ///< nor back

  [[nodiscard]] Vec3 point(double s, double d, double above = 0) const;
  /// x along the street (or against it), y to the left of that.
  [[nodiscard]] Place place(double s, double d, bool against) const;
};

/// From the street's middle to that of the right-hand lane; cars are parked at the kerb.
[[nodiscard]] double lane_m(const TownStyle& style);

/// Adds houses, trees, parked cars, people, traffic and lamp posts along both sides to the scene. What moves
/// keeps out of a way that the robot takes: the lane, or with `on_pavement` the pavement.
void furnish_street(const Street& street, const TownStyle& style, bool on_pavement, Scene& scene,
                    Random& random);

}  // namespace egofocus::citysim
