// A town's streets: a lattice of uneven distances, bent and sloped a little, and a random way through it.
#pragma once

#include <set>
#include <utility>
#include <vector>

#include "citysim/mesh.hpp"
#include "citysim/scenes.hpp"

namespace egofocus::citysim {

class TownPlan {
 public:
  using Crossing = std::pair<int, int>;  ///< column, row of the lattice

  TownPlan(const TownStyle& style, double way_m, Random& random);

  /// Where a point of the flat plan lies in the world, on the ground.
  [[nodiscard]] Vec3 ground(double x, double y, double above = 0) const;
  /// x along the plan's direction `angle` (0: along its x), y to the left of it, z straight up.
  [[nodiscard]] Place place(double x, double y, double angle) const;

  [[nodiscard]] double column_x(int column) const { return xs_[static_cast<std::size_t>(column)]; }
  [[nodiscard]] double row_y(int row) const { return ys_[static_cast<std::size_t>(row)]; }
  /// Crossings on the way and next to it: the town is built around these.
  [[nodiscard]] const std::set<Crossing>& built() const { return built_; }
  [[nodiscard]] bool has(const Crossing& crossing) const { return built_.count(crossing) != 0; }

  /// Does the way go from this crossing straight to that one?
  [[nodiscard]] bool travelled(const Crossing& from, const Crossing& to) const {
    return travelled_.count({from, to}) != 0;
  }

  /// The way, `right_m` to the right of the street's middle, in the world; a point every few metres.
  [[nodiscard]] Route route(double right_m, double speed_limit_m_s) const;

 private:
  static constexpr int kSide = 40;
  std::vector<double> xs_, ys_;
  std::vector<Crossing> way_;
  std::set<Crossing> built_;
  std::set<std::pair<Crossing, Crossing>> travelled_;
  double bend_m_, wave_m_, slope_x_, slope_y_, bend_length_m_, phase_[4];
};

}  // namespace egofocus::citysim
