// What a scene says about where a robot may go. A scene's builder fills it; drive, fly and slide read it.
#pragma once

#include <vector>

#include "citysim/vec3.hpp"

namespace egofocus::citysim {

using sim::operator+;
using sim::operator-;
using sim::operator*;

/// A road, or a corridor's middle line: points at its surface, a lane's centre. A robot starts at the first.
struct Route {
  std::vector<sim::Vec3> points;        ///< straight pieces; corners are rounded by who drives it
  std::vector<double> speed_limit_m_s;  ///< of the piece that begins at the point; as many as points
  /// Free to each side. Corners are rounded within it, so it bounds their radius: a right angle's is at most
  /// 2.5 half widths (cars want 5 m and more), and needs legs of 3.6 radii.
  double half_width_m = 1.5;
  bool closed = false;  ///< the last point leads to the first
};

/// A box without obstacles, where a camera may be.
struct FreeBox {
  sim::Vec3 low;
  sim::Vec3 high;
};

struct Ways {
  Route route;                    ///< towns, corridors
  std::vector<FreeBox> boxes;     ///< rooms, desks: each overlaps the next by enough to pass through
  std::vector<sim::Vec3> sights;  ///< what is worth looking at: centres of objects and walls
};

}  // namespace egofocus::citysim
