#include "citysim/view_polygons.hpp"

#include <algorithm>
#include <limits>

#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kNear_m = 0.01;

RayPlane plane(const Vec3& normal, double scale) {
  return {static_cast<float>(scale * normal[0]), static_cast<float>(scale * normal[1]),
          static_cast<float>(scale * normal[2])};
}

/// value = gradient . p + offset in the object's frame, p_camera = R p + c: value = (R gradient) . p_camera +
/// rest, and p_camera = (x, y, 1) / inverse_depth. `period`: whole periods are taken off the rest, so that a
/// float holds it.
RayAffine in_view(const Affine& affine, const Pose& to_camera, double period) {
  const Vec3 gradient = to_camera.rotation * affine.gradient;
  double rest = affine.offset - dot(gradient, to_camera.position);
  if (period > 0) rest -= period * floor_of(rest / period);
  return {static_cast<float>(gradient[0]), static_cast<float>(gradient[1]), static_cast<float>(gradient[2]),
          static_cast<float>(rest)};
}

/// May the sphere be seen? Tested against the four sides of the view and the camera's own plane.
bool in_sight(const Vec3& centre, double radius, const Optics::Ray& reach) {
  if (centre[2] < -radius) return false;
  const double sx = square_root(1.0 + reach.x * reach.x);
  const double sy = square_root(1.0 + reach.y * reach.y);
  return absolute(centre[0]) - reach.x * centre[2] < radius * sx &&
         absolute(centre[1]) - reach.y * centre[2] < radius * sy;
}

}  // namespace

void objects_in_sight(const Scene& scene, const Pose& camera, double t_s, const Optics& optics,
                      std::vector<ObjectInSight>& out) {
  const Mat3 to_camera = transpose(camera.rotation);
  const double pixel = 1.0 / optics.camera().intrinsics.fx_px;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Object& object = scene.objects[i];
    ObjectInSight seen;
    seen.object = static_cast<std::int32_t>(i);
    if (object.moves) {
      const Pose pose = object.pose_at(t_s);
      seen.to_camera = {to_camera * pose.rotation, to_camera * (pose.position - camera.position)};
    } else {
      seen.to_camera = {to_camera, to_camera * (-1.0 * camera.position)};
    }
    const Vec3 centre = seen.to_camera.rotation * object.centre + seen.to_camera.position;
    const double radius = object.radius_m;
    if (!in_sight(centre, radius, optics.reach())) continue;
    const double away = square_root(dot(centre, centre));
    if (radius < 0.3 * pixel * away) continue;  // smaller than a pixel
    seen.nearest_m = away - radius;
    const double z = centre[2] - radius;
    if (z > kNear_m) {
      seen.largest_inverse_depth = static_cast<float>(1.0 / z);
      // The box around the sphere, seen from its near side: wider than the sphere itself.
      const auto bound = [&](double at, double sign) {
        return (at + sign * radius) / ((at + sign * radius) * sign > 0 ? z : z + 2 * radius);
      };
      seen.tiles = optics.tiles_in(
          static_cast<float>(bound(centre[0], -1) - 1e-5), static_cast<float>(bound(centre[0], 1) + 1e-5),
          static_cast<float>(bound(centre[1], -1) - 1e-5), static_cast<float>(bound(centre[1], 1) + 1e-5));
    } else {
      seen.largest_inverse_depth = std::numeric_limits<float>::max();
      seen.tiles = optics.tiles_in(-1e9f, 1e9f, -1e9f, 1e9f);
    }
    out.push_back(seen);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const ObjectInSight& a, const ObjectInSight& b) { return a.nearest_m < b.nearest_m; });
}

bool outline(const Polygon& polygon, const Pose& to_camera, const Optics& optics, Outline& out) {
  out.normal = to_camera.rotation * polygon.normal;
  out.corners[0] = to_camera.rotation * polygon.corners[0] + to_camera.position;
  out.distance_m = -dot(out.normal, out.corners[0]);
  if (!(out.distance_m > 1e-4)) return false;
  const int n = polygon.corner_count;
  for (int i = 1; i < n; ++i) {
    out.corners[i] = to_camera.rotation * polygon.corners[static_cast<std::size_t>(i)] + to_camera.position;
  }
  const Optics::Ray reach = optics.reach();
  double nearest = std::numeric_limits<double>::max();
  bool behind = false;
  double low_x = 1e9, high_x = -1e9, low_y = 1e9, high_y = -1e9;
  int outside[4] = {0, 0, 0, 0};
  for (int i = 0; i < n; ++i) {
    const Vec3& c = out.corners[i];
    nearest = std::min(nearest, c[2]);
    outside[0] += c[0] < -reach.x * c[2];
    outside[1] += c[0] > reach.x * c[2];
    outside[2] += c[1] < -reach.y * c[2];
    outside[3] += c[1] > reach.y * c[2];
  }
  for (const int count : outside) {
    if (count == n) return false;
  }
  for (int i = 0; i < n && !behind; ++i) {
    const Vec3& c = out.corners[i];
    behind = c[2] < kNear_m;
    const double per_z = 1.0 / c[2];
    low_x = std::min(low_x, c[0] * per_z);
    high_x = std::max(high_x, c[0] * per_z);
    low_y = std::min(low_y, c[1] * per_z);
    high_y = std::max(high_y, c[1] * per_z);
  }
  if (behind) {
    // Its outline wraps around: the edge tests alone decide.
    low_x = low_y = -1e9;
    high_x = high_y = 1e9;
  }
  out.tiles = optics.tiles_in(static_cast<float>(low_x - 1e-5), static_cast<float>(high_x + 1e-5),
                              static_cast<float>(low_y - 1e-5), static_cast<float>(high_y + 1e-5));
  out.largest_inverse_depth =
      behind ? std::numeric_limits<float>::max() : static_cast<float>(1.0 / nearest * (1 + 1e-6));
  return true;
}

ViewPolygon view_polygon(const Polygon& polygon, const Outline& outline) {
  ViewPolygon view;
  // The normal points to the camera, so seen from there the corners run counter-clockwise in x right, y up,
  // and clockwise in x right, y down: an edge's plane through the camera is corner x next corner, negated.
  // Computed from the same two corners, neighbours get exactly opposite numbers: no crack, no pixel lost.
  view.edge_count = polygon.corner_count;
  for (int i = 0; i < view.edge_count; ++i) {
    view.edges[i] = plane(cross(outline.corners[i], outline.corners[(i + 1) % view.edge_count]), -1.0);
  }
  view.inverse_depth = plane(outline.normal, -1.0 / outline.distance_m);
  view.facing = static_cast<float>(outline.distance_m);
  view.polygon = &polygon;
  return view;
}

ViewSurface view_surface(const Polygon& polygon, const Pose& to_camera) {
  return {in_view(polygon.u, to_camera, Texture::kSide), in_view(polygon.v, to_camera, Texture::kSide),
          in_view(polygon.steady, to_camera, 0), in_view(polygon.flickering, to_camera, 0)};
}

}  // namespace egofocus::citysim
