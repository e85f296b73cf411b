// Building blocks of scenes: quads, boxes, prisms, blobs with textures in metres.
#pragma once

#include <vector>

#include "citysim/scene.hpp"

namespace egofocus::citysim {

/// How a surface looks. `metres` is what one period of the texture covers.
struct Surface {
  int texture = 0;
  double metres = 2;
  Colour colour{1, 1, 1};
  float emission = 0;
};

/// A frame to build in: origin and axes in the object's frame.
struct Place {
  Vec3 origin{0, 0, 0};
  Vec3 x{1, 0, 0};
  Vec3 y{0, 1, 0};
  Vec3 z{0, 0, 1};

  [[nodiscard]] Vec3 point(double a, double b, double c) const { return origin + a * x + b * y + c * z; }
  [[nodiscard]] Place at(double a, double b, double c) const { return {point(a, b, c), x, y, z}; }
  /// Turned about its z axis.
  [[nodiscard]] Place turned(double angle) const;
};

/// A texture coordinate pair, in metres on the surface.
struct TexturePoint {
  double u;
  double v;
};

/// Collects polygons of one object.
class Mesh {
 public:
  /// Corners counter-clockwise from the front. `shift` moves the texture, so that equal things look unequal.
  void quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Surface& surface,
            TexturePoint shift = {0, 0});
  /// Texture coordinates are given, for surfaces that must join their neighbours.
  void triangle(const Vec3& a, const Vec3& b, const Vec3& c, TexturePoint ta, TexturePoint tb,
                TexturePoint tc, const Surface& surface);
  /// Centred in x and y, standing on z = 0 of `place`. The bottom is left out unless asked for.
  void box(const Place& place, double length, double width, double height, const Surface& sides,
           const Surface& top, bool bottom = false);
  /// Upright n-sided prism; `taper` is the top's radius over the bottom's.
  void prism(const Place& place, int sides, double radius, double height, const Surface& surface,
             double taper = 1);
  /// A rough ball of 20 triangles, radius varied by `rough` (0..1).
  void blob(const Vec3& centre, double radius, double rough, const Surface& surface, Random& random);

  [[nodiscard]] bool empty() const { return polygons_.empty(); }
  /// Takes all that was built as one object that stands still.
  [[nodiscard]] Object take();

 private:
  std::vector<Polygon> polygons_;
};

}  // namespace egofocus::citysim
