#include "citysim/mesh.hpp"

#include <array>
#include <utility>

namespace egofocus::citysim {
namespace {

Vec3 unit(const Vec3& v) {
  return (1.0 / square_root(dot(v, v))) * v;
}

/// The linear function on the plane of a triangle that takes the given values at its corners.
Affine through(const Vec3& a, const Vec3& b, const Vec3& c, double at_a, double at_b, double at_c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const double bb = dot(ab, ab);
  const double bc = dot(ab, ac);
  const double cc = dot(ac, ac);
  const double det = bb * cc - bc * bc;
  if (det <= 1e-18) return {{0, 0, 0}, at_a};
  const double s = ((at_b - at_a) * cc - (at_c - at_a) * bc) / det;
  const double t = ((at_c - at_a) * bb - (at_b - at_a) * bc) / det;
  const Vec3 gradient = s * ab + t * ac;
  return {gradient, at_a - dot(gradient, a)};
}

}  // namespace

Place Place::turned(double angle) const {
  const double c = cosine(angle);
  const double s = sine(angle);
  return {origin, c * x + s * y, c * y - s * x, z};
}

void Mesh::quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Surface& surface,
                TexturePoint shift) {
  const double texels_per_m = Texture::kSide / surface.metres;
  const Vec3 along = unit(b - a);
  const Vec3 normal = unit(cross(b - a, d - a));
  const Vec3 across = cross(normal, along);
  Polygon polygon;
  polygon.corners = {a, b, c, d};
  polygon.texture = surface.texture;
  polygon.colour = surface.colour;
  polygon.emission = surface.emission;
  // The picture's rows run down: v falls along `across`.
  polygon.u = {texels_per_m * along, texels_per_m * (shift.u - dot(along, a))};
  polygon.v = {(-texels_per_m) * across, texels_per_m * (shift.v + dot(across, a))};
  polygons_.push_back(polygon);
}

void Mesh::triangle(const Vec3& a, const Vec3& b, const Vec3& c, TexturePoint ta, TexturePoint tb,
                    TexturePoint tc, const Surface& surface) {
  const double scale = Texture::kSide / surface.metres;
  Polygon polygon;
  polygon.corners = {a, b, c, c};
  polygon.corner_count = 3;
  polygon.texture = surface.texture;
  polygon.colour = surface.colour;
  polygon.emission = surface.emission;
  polygon.u = through(a, b, c, scale * ta.u, scale * tb.u, scale * tc.u);
  polygon.v = through(a, b, c, scale * ta.v, scale * tb.v, scale * tc.v);
  polygons_.push_back(polygon);
}

void Mesh::box(const Place& place, double length, double width, double height, const Surface& sides,
               const Surface& top, bool bottom) {
  const double l = 0.5 * length;
  const double w = 0.5 * width;
  const auto p = [&](double a, double b, double c) { return place.point(a, b, c); };
  quad(p(-l, -w, 0), p(l, -w, 0), p(l, -w, height), p(-l, -w, height), sides);
  quad(p(l, -w, 0), p(l, w, 0), p(l, w, height), p(l, -w, height), sides, {length, 0});
  quad(p(l, w, 0), p(-l, w, 0), p(-l, w, height), p(l, w, height), sides, {length + width, 0});
  quad(p(-l, w, 0), p(-l, -w, 0), p(-l, -w, height), p(-l, w, height), sides, {2 * length + width, 0});
  quad(p(-l, -w, height), p(l, -w, height), p(l, w, height), p(-l, w, height), top);
  if (bottom) quad(p(-l, w, 0), p(l, w, 0), p(l, -w, 0), p(-l, -w, 0), sides);
}

void Mesh::prism(const Place& place, int sides, double radius, double height, const Surface& surface,
                 double taper) {
  const double step = 6.283185307179586 / sides;
  const auto at = [&](int i, double r, double z) {
    return place.point(r * cosine(step * i), r * sine(step * i), z);
  };
  const double top = taper * radius;
  const double facet = 2 * radius * sine(0.5 * step);
  for (int i = 0; i < sides; ++i) {
    quad(at(i, radius, 0), at(i + 1, radius, 0), at(i + 1, top, height), at(i, top, height), surface,
         {facet * i, 0});
  }
  if (top <= 0.001) return;
  for (int i = 1; i + 1 < sides; ++i) {
    triangle(at(0, top, height), at(i, top, height), at(i + 1, top, height), {0, 0}, {top, 0}, {top, top},
             surface);
  }
}

void Mesh::blob(const Vec3& centre, double radius, double rough, const Surface& surface, Random& random) {
  // The icosahedron: corners are the cyclic permutations of (0, +-1, +-golden ratio).
  constexpr double kGolden = 1.6180339887498949;
  constexpr double kNorm = 0.5257311121191336;  // 1 / |(1, golden)|
  std::array<Vec3, 12> corners;
  for (std::size_t i = 0; i < 12; ++i) {
    const double a = (i & 1) ? 1.0 : -1.0;
    const double b = (i & 2) ? kGolden : -kGolden;
    const double grown = radius * kNorm * (1.0 + rough * random.uniform(-1, 1));
    corners[i] = i < 4 ? grown * Vec3{0, a, b} : i < 8 ? grown * Vec3{a, b, 0} : grown * Vec3{b, 0, a};
  }
  // Faces: three corners that are an edge's length apart from each other on the regular body.
  static constexpr std::array<std::array<std::uint8_t, 3>, 20> kFaces{{
      {0, 1, 8},  {0, 1, 10}, {0, 4, 5},  {0, 4, 8},   {0, 5, 10}, {1, 6, 7},   {1, 6, 8},
      {1, 7, 10}, {2, 3, 9},  {2, 3, 11}, {2, 4, 5},   {2, 4, 9},  {2, 5, 11},  {3, 6, 7},
      {3, 6, 9},  {3, 7, 11}, {4, 8, 9},  {5, 10, 11}, {6, 8, 9},  {7, 10, 11},
  }};
  for (const auto& face : kFaces) {
    Vec3 a = corners[face[0]];
    Vec3 b = corners[face[1]];
    const Vec3 c = corners[face[2]];
    if (dot(cross(b - a, c - a), a + b + c) < 0) std::swap(a, b);
    const double side = 1.05 * radius;
    const TexturePoint shift{random.uniform(0, surface.metres), random.uniform(0, surface.metres)};
    triangle(centre + a, centre + b, centre + c, shift, {shift.u + side, shift.v},
             {shift.u + 0.5 * side, shift.v + 0.87 * side}, surface);
  }
}

Object Mesh::take() {
  Object object;
  object.polygons = std::exchange(polygons_, {});
  return object;
}

}  // namespace egofocus::citysim
