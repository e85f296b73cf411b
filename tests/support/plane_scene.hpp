// Textured rectangles in front of a textured wall; depth and brightness along a ray are exact.
#pragma once

#include <cstdint>
#include <vector>

#include "citysim/vec3.hpp"

namespace egofocus::sim {

/// Where the camera is: p_world = rotation * p_camera + position.
struct CameraPose {
  Mat3 rotation = kIdentity;
  Vec3 position{0, 0, 0};
};

/// World: x forward, y left, z up; metres.
struct Rectangle {
  Vec3 centre;
  Vec3 right;  ///< unit vectors that span it
  Vec3 up;
  double half_width_m;
  double half_height_m;
};

/// What a ray meets. `depth_m` is along the optical axis, not along the ray.
struct Hit {
  double depth_m = 0;
  double log_intensity = 0;
};

class PlaneScene {
 public:
  /// Five rectangles between 1.75 and 2.9 m and a wall at 3.8 m, seen from near the origin; detail
  /// everywhere.
  static PlaneScene standard(std::uint64_t seed);

  PlaneScene(std::vector<Rectangle> rectangles, std::uint64_t seed);

  /// The camera that the next casts look from.
  void look_from(const CameraPose& pose);

  /// The nearest hit along (x, y, 1) in camera coordinates. Depth 0: nothing there.
  [[nodiscard]] Hit cast(double x, double y) const;

 private:
  static constexpr int kTextureSide = 256;
  /// Periodic picture of log intensity, sampled bilinearly.
  struct Texture {
    double texels_per_m = 1;
    std::vector<float> log_intensity;
    [[nodiscard]] double at(double u_m, double v_m) const;
  };
  /// A rectangle in the coordinates of the camera that looks.
  struct Seen {
    Vec3 centre, right, up, normal;
    double distance = 0;  // normal . centre
  };
  static Texture make_texture(double texels_per_m, std::uint64_t seed);

  std::vector<Rectangle> rectangles_;
  std::vector<Texture> textures_;
  std::vector<Seen> seen_;
};

}  // namespace egofocus::sim
