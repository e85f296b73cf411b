// How bright what a ray meets is: renderer's third step.
#pragma once

#include <span>

#include "citysim/raster.hpp"
#include "citysim/scene.hpp"

namespace egofocus::citysim {

/// What shading needs to know of the moment.
struct ShadeMoment {
  const Scene* scene = nullptr;
  Mat3 world_from_camera;
  float flicker = 1;
  float pixels_per_unit = 1;  ///< focal length: sets the texture level
};

/// A polygon of the view with what its look needs.
struct LitPolygon {
  ViewPolygon shape;
  ViewSurface surface;
  bool has_surface = false;  ///< only those that are met get one
};

/// Of each ray of a tile.
struct TileLooks {
  alignas(64) float light[Optics::kTilePixels];  ///< linear, at the moment
  alignas(64) float mains[Optics::kTilePixels];  ///< what flickers of it, at the lamps' mean strength
  alignas(64) std::int32_t object[Optics::kTilePixels];
};

/// `headlight`: of each ray of the tile, what the robot's own lamps send along it. Colours too where `colour`
/// is not null.
void shade(const ShadeMoment& moment, std::span<const ObjectInSight> in_sight, std::span<LitPolygon> polygons,
           const Optics::Tile& tile, const float* headlight, const TileHits& hits, TileLooks& looks,
           Colour* colour);

/// Light of the robot's own lamps along the ray (x, y, 1): a soft cone around the optical axis, a little
/// below it. Times the cosine on the surface, over the square of the distance.
float headlight_along(float x, float y);

}  // namespace egofocus::citysim
