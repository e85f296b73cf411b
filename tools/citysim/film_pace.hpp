// How fast the picture moves, tile by tile: what decides when a tile has to be rendered again.
#pragma once

#include <cstdint>
#include <vector>

#include "citysim/optics.hpp"
#include "citysim/renderer.hpp"
#include "citysim/world.hpp"

namespace egofocus::citysim {

/// px/s, from the motion field of the view's own depth and the movers' velocities.
struct FilmPace {
  std::vector<float> tile;  ///< the fastest of the tile's samples
  double fast = 0;          ///< 99 of 100 samples of the view are slower
};

FilmPace pace_of(const World& world, const Optics& optics, const View& view, std::int64_t t_us);

/// Each tile at least as fast as its eight neighbours: what enters it soon is there now.
void widen(FilmPace& pace, const Optics& optics);

}  // namespace egofocus::citysim
