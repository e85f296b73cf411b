// Which polygon each ray of a tile meets first: renderer's second step.
#pragma once

#include <cstdint>

#include "citysim/optics.hpp"
#include "citysim/view_polygons.hpp"

namespace egofocus::citysim {

struct TileHits {
  alignas(64) float inverse_depth[Optics::kTilePixels];
  alignas(64) std::int32_t polygon[Optics::kTilePixels];  ///< index into the view's polygons; -1: none
  float farthest = 0;                                     ///< smallest inverse depth of the tile

  void clear();
};

/// Puts the polygon where it is nearer than what is there. Of two at the same depth, the first stays.
void raster(const ViewPolygon& polygon, std::int32_t index, const Optics::Tile& tile, TileHits& hits);

}  // namespace egofocus::citysim
