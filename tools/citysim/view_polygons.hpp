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

/// Where a polygon that faces the camera may lie in its view.
struct Outline {
  Vec3 corners[4];  ///< in the camera's frame
  Vec3 normal;
  double distance_m = 0;            ///< of the camera from the polygon's plane, > 0
  float largest_inverse_depth = 0;  ///< over its corners; infinite when it reaches behind the camera
  Optics::TileRange tiles{};
};

/// False when it turns its back or lies beside the view.
bool outline(const Polygon& polygon, const Pose& to_camera, const Optics& optics, Outline& out);

/// What decides which rays meet a polygon, and where.
struct ViewPolygon {
  RayPlane edges[4];  ///< all >= 0 inside
  int edge_count = 0;
  RayPlane inverse_depth;
  float facing = 0;  ///< distance of the camera from the polygon's plane
  const Polygon* polygon = nullptr;
  std::int32_t in_sight = 0;  ///< index into the view's ObjectInSight
  std::int32_t object = 0;
};

ViewPolygon view_polygon(const Polygon& polygon, const Outline& outline);

/// What decides how bright it looks.
struct ViewSurface {
  RayAffine u, v, steady, flickering;
};

ViewSurface view_surface(const Polygon& polygon, const Pose& to_camera);

}  // namespace egofocus::citysim
