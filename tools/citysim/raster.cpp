#include "citysim/raster.hpp"

#include <algorithm>
#include <bit>

#include "citysim/clones.hpp"

namespace egofocus::citysim {
namespace {

float largest_in(const RayPlane& p, const Optics::Tile& tile) {
  return p.x * (p.x > 0 ? tile.high_x : tile.low_x) + p.y * (p.y > 0 ? tile.high_y : tile.low_y) + p.one;
}

CITYSIM_CLONES void cover(const RayPlane* edges, const RayPlane& depth, std::int32_t index,
                          const float* __restrict xs, const float* __restrict ys, float* __restrict depths,
                          std::int32_t* __restrict polygons) {
  const RayPlane a = edges[0];
  const RayPlane b = edges[1];
  const RayPlane c = edges[2];
  const RayPlane d = edges[3];
  for (int i = 0; i < Optics::kTilePixels; ++i) {
    const float x = xs[i];
    const float y = ys[i];
    const bool inside = (a.x * x + a.y * y + a.one >= 0) & (b.x * x + b.y * y + b.one >= 0) &
                        (c.x * x + c.y * y + c.one >= 0) & (d.x * x + d.y * y + d.one >= 0);
    const float at = depth.x * x + depth.y * y + depth.one;
    const bool nearer = inside & (at > depths[i]);
    depths[i] = nearer ? at : depths[i];
    polygons[i] = nearer ? index : polygons[i];
  }
}

/// Floats >= 0 are ordered as their bits are, and a minimum of integers becomes vector code.
CITYSIM_CLONES float smallest(const float* values) {
  std::int32_t out = std::bit_cast<std::int32_t>(values[0]);
  for (int i = 1; i < Optics::kTilePixels; ++i) {
    const std::int32_t value = std::bit_cast<std::int32_t>(values[i]);
    out = value < out ? value : out;
  }
  return std::bit_cast<float>(out);
}

}  // namespace

void TileHits::clear() {
  std::fill(inverse_depth, inverse_depth + Optics::kTilePixels, 0.0f);
  std::fill(polygon, polygon + Optics::kTilePixels, -1);
  farthest = 0;
}

void raster(const ViewPolygon& polygon, std::int32_t index, const Optics::Tile& tile, TileHits& hits) {
  for (int i = 0; i < polygon.edge_count; ++i) {
    if (largest_in(polygon.edges[i], tile) < 0) return;
  }
  if (largest_in(polygon.inverse_depth, tile) <= hits.farthest) return;
  RayPlane edges[4];
  for (int i = 0; i < 4; ++i) edges[i] = polygon.edges[std::min(i, polygon.edge_count - 1)];
  cover(edges, polygon.inverse_depth, index, tile.x, tile.y, hits.inverse_depth, hits.polygon);
  hits.farthest = smallest(hits.inverse_depth);
}

}  // namespace egofocus::citysim
