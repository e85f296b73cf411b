#include "citysim/scene.hpp"

#include <algorithm>

namespace egofocus::citysim {
namespace {

constexpr double kTurn = 6.283185307179586;

Vec3 normal_of(const Polygon& polygon) {
  const Vec3 n =
      cross(polygon.corners[1] - polygon.corners[0],
            polygon.corners[static_cast<std::size_t>(polygon.corner_count - 1)] - polygon.corners[0]);
  const double length = square_root(dot(n, n));
  return length > 0 ? (1.0 / length) * n : Vec3{0, 0, 1};
}

/// Lambert's law with a fall-off that stays finite near the lamp.
double lamp_light(const Lamp& lamp, const Vec3& point, const Vec3& normal) {
  const Vec3 to_lamp = lamp.position - point;
  const double square = dot(to_lamp, to_lamp) + 0.3;
  const double facing = dot(to_lamp, normal) / square_root(square);
  return facing > 0 ? lamp.strength * facing / square : 0;
}

/// The linear function closest to the values at the corners (exact for triangles).
Affine fit(const Polygon& polygon, const std::array<double, 4>& values) {
  const int n = polygon.corner_count;
  Vec3 middle{0, 0, 0};
  double mean = 0;
  for (int i = 0; i < n; ++i) {
    middle = middle + (1.0 / n) * polygon.corners[static_cast<std::size_t>(i)];
    mean += values[static_cast<std::size_t>(i)] / n;
  }
  const Vec3 along = polygon.corners[1] - polygon.corners[0];
  const double length = square_root(dot(along, along));
  if (length == 0) return {{0, 0, 0}, mean};
  const Vec3 e1 = (1.0 / length) * along;
  const Vec3 e2 = cross(polygon.normal, e1);
  double xx = 0, xy = 0, yy = 0, xv = 0, yv = 0;
  for (int i = 0; i < n; ++i) {
    const Vec3 p = polygon.corners[static_cast<std::size_t>(i)] - middle;
    const double x = dot(p, e1);
    const double y = dot(p, e2);
    const double v = values[static_cast<std::size_t>(i)] - mean;
    xx += x * x;
    xy += x * y;
    yy += y * y;
    xv += x * v;
    yv += y * v;
  }
  const double det = xx * yy - xy * xy;
  if (det <= 1e-12 * xx * yy) return {{0, 0, 0}, mean};
  const Vec3 gradient = ((xv * yy - yv * xy) / det) * e1 + ((yv * xx - xv * xy) / det) * e2;
  return {gradient, mean - dot(gradient, middle)};
}

void bound(Object& object) {
  Vec3 low{1e9, 1e9, 1e9};
  Vec3 high{-1e9, -1e9, -1e9};
  for (Polygon& polygon : object.polygons) {
    polygon.normal = normal_of(polygon);
    for (const Vec3& corner : polygon.corners) {
      for (std::size_t i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], corner[i]);
        high[i] = std::max(high[i], corner[i]);
      }
    }
  }
  object.centre = 0.5 * (low + high);
  const Vec3 half = 0.5 * (high - low);
  object.radius_m = square_root(dot(half, half));
}

/// `pose`: object's frame to the world. A mover keeps the light of its start.
void light(Object& object, const Scene& scene) {
  const Pose pose = object.pose_at(0);
  std::vector<const Lamp*> near;
  const Vec3 centre = pose.rotation * object.centre + pose.position;
  for (const Lamp& lamp : scene.lamps) {
    const Vec3 away = lamp.position - centre;
    const double reach =
        object.radius_m + 40.0 * square_root(lamp.strength);  // light below 0.0006 is left out
    if (dot(away, away) < reach * reach) near.push_back(&lamp);
  }
  for (Polygon& polygon : object.polygons) {
    const Vec3 normal = pose.rotation * polygon.normal;
    const double to_sun = dot(normal, scene.sky.to_sun);
    const double upward = 0.75 + 0.25 * normal[2];
    const double far = scene.sky.ambient * upward + (to_sun > 0 ? scene.sky.sun * to_sun : 0);
    std::array<double, 4> steady{far, far, far, far};
    std::array<double, 4> flickering{0, 0, 0, 0};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 point = pose.rotation * polygon.corners[i] + pose.position;
      for (const Lamp* lamp : near)
        (lamp->mains ? flickering : steady)[i] += lamp_light(*lamp, point, normal);
    }
    polygon.steady = fit(polygon, steady);
    polygon.flickering = fit(polygon, flickering);
  }
}

}  // namespace

Pose Object::pose_at(double t_s) const {
  if (!moves) return {};
  double t = t_s + phase_s;
  if (period_s > 0) t -= period_s * floor_of(t / period_s);
  return {start.rotation, start.position + t * velocity_m_s};
}

double Scene::flicker_at(double t_s) const {
  return 1.0 + flicker_depth * sine(kTurn * (flicker_hz * t_s - floor_of(flicker_hz * t_s)));
}

void finish_scene(Scene& scene) {
  for (Object& object : scene.objects) {
    bound(object);
    light(object, scene);
  }
}

}  // namespace egofocus::citysim
