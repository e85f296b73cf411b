// The polygons that a camera may see, as linear functions of the ray (x, y): renderer's first step.
#pragma once

#include <cstdint>
#include <vector>

#include "citysim/optics.hpp"
#include "citysim/scene.hpp"

namespace egofocus::citysim {

/// x * ray.x + y * ray.y + one
struct RayPlane {
  float x = 0;
  float y = 0;
  float one = 0;
};

/// value(p) on the polygon = (x * ray.x + y * ray.y + one) / inverse_depth + offset
struct RayAffine {
  float x = 0;
  float y = 0;
  float one = 0;
  float offset = 0;
};

struct ViewPolygon {
  RayPlane edges[4];  ///< all >= 0 inside
  int edge_count = 0;
  RayPlane inverse_depth;
  float largest_inverse_depth = 0;  ///< over its corners; infinite when it reaches behind the camera
  float low_x = 0, high_x = 0, low_y = 0, high_y = 0;  ///< bounds of its rays
  RayAffine u, v, steady, flickering;
  const Polygon* polygon = nullptr;
  std::int32_t object = 0;
  float facing = 0;  ///< distance of the camera from the polygon's plane
};

/// An object whose bounding sphere meets the view.
struct ObjectInSight {
  std::int32_t object = 0;
  Pose to_camera;                   ///< object's frame to the camera's
  double nearest_m = 0;             ///< of its sphere
  float largest_inverse_depth = 0;  ///< no ray meets it nearer than that
  Optics::TileRange tiles{};        ///< that its sphere may meet
};

/// Near ones first.
void objects_in_sight(const Scene& scene, const Pose& camera, double t_s, const Optics& optics,
                      std::vector<ObjectInSight>& out);

/// Appends the object's polygons that face the camera.
void view_polygons(const Scene& scene, const ObjectInSight& object, const Optics& optics,
                   std::vector<ViewPolygon>& out);

}  // namespace egofocus::citysim
