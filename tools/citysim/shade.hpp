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

/// Linear light of each ray of the tile; colours too where `colour` is not null.
void shade(const ShadeMoment& moment, std::span<const ViewPolygon> polygons, const Optics::Tile& tile,
           const TileHits& hits, float* light, Colour* colour);

}  // namespace egofocus::citysim
