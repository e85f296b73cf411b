// A wall that stands askew and a box in front of it, seen by a camera that turns and moves: inverse depth
// along any ray, written down, for tests of what moves depth maps.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "egofocus/types.hpp"
#include "pipeline/motion_track.hpp"

namespace egofocus::test {

inline constexpr Intrinsics kGrid{96, 72, 80, 82, 46.5, 36.25};
inline constexpr double kScale_per_m = 1.0 / 4096;
inline constexpr std::size_t kPixels = 96 * 72;

struct Map {
  std::vector<std::uint16_t> inverse_depth = std::vector<std::uint16_t>(kPixels, 0);
  std::vector<std::uint8_t> confidence = std::vector<std::uint8_t>(kPixels, 0);
  void set(std::int32_t x, std::int32_t y, double rho_per_m, std::uint8_t sure = 200) {
    const auto at = static_cast<std::size_t>(y * kGrid.width_px + x);
    inverse_depth[at] = static_cast<std::uint16_t>(std::lround(rho_per_m / kScale_per_m));
    confidence[at] = sure;
  }
  [[nodiscard]] std::size_t known() const {
    return kPixels - static_cast<std::size_t>(std::count(confidence.begin(), confidence.end(), 0));
  }
};

struct Vector {
  double x, y, z;
};

/// A camera in the world of the first one: its axes as columns, its centre.
struct Camera {
  double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // [axis][component]
  Vector centre{0, 0, 0};

  static Camera turned(double yaw, double pitch, double roll) {
    const double cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch);
    const double cr = std::cos(roll), sr = std::sin(roll);
    // Right, down and forward: first about the vertical, then about the new right, then about the new
    // forward.
    const double right[3] = {cy, 0, -sy};
    const double forward0[3] = {sy, 0, cy};
    const double down[3] = {0, 1, 0};
    double forward[3], down1[3];
    for (int i = 0; i < 3; ++i) {
      forward[i] = cp * forward0[i] - sp * down[i];
      down1[i] = cp * down[i] + sp * forward0[i];
    }
    Camera camera;
    for (int i = 0; i < 3; ++i) {
      camera.axes[0][i] = cr * right[i] + sr * down1[i];
      camera.axes[1][i] = cr * down1[i] - sr * right[i];
      camera.axes[2][i] = forward[i];
    }
    return camera;
  }
  [[nodiscard]] Vector ray(double u, double v) const {
    const double x = (u - kGrid.cx_px) / kGrid.fx_px;
    const double y = (v - kGrid.cy_px) / kGrid.fy_px;
    return {x * axes[0][0] + y * axes[1][0] + axes[2][0], x * axes[0][1] + y * axes[1][1] + axes[2][1],
            x * axes[0][2] + y * axes[1][2] + axes[2][2]};
  }
  /// From the first camera's coordinates to this one's.
  [[nodiscard]] MotionKnot from_first() const {
    MotionKnot knot{};
    for (int row = 0; row < 3; ++row) {
      for (int i = 0; i < 3; ++i) knot.rotation[3 * row + i] = axes[row][i];
      knot.centre_m[row] = -(axes[row][0] * centre.x + axes[row][1] * centre.y + axes[row][2] * centre.z);
    }
    return knot;
  }
};

/// A wall that stands askew, and, where asked for, a box's front in front of it. Inverse depth along the
/// optical axis; a ray's parameter is just that depth, because its forward part is 1.
struct Scene {
  bool has_box = false;
  [[nodiscard]] bool on_box(const Vector& c, const Vector& d) const {
    const double t = (1.5 - c.z) / d.z;
    const double x = c.x + t * d.x;
    const double y = c.y + t * d.y;
    return has_box && t > 0 && x > -0.3 && x < 0.25 && y > -0.2 && y < 0.4;
  }
  [[nodiscard]] double rho(const Camera& camera, double u, double v) const {
    const Vector c = camera.centre;
    const Vector d = camera.ray(u, v);
    if (on_box(c, d)) return d.z / (1.5 - c.z);
    // 0.2 x - 0.1 y + z = 4
    return (0.2 * d.x - 0.1 * d.y + d.z) / (4 - 0.2 * c.x + 0.1 * c.y - c.z);
  }
};

inline Map seen(const Scene& scene, const Camera& camera) {
  Map map;
  for (std::int32_t y = 0; y < kGrid.height_px; ++y) {
    for (std::int32_t x = 0; x < kGrid.width_px; ++x) map.set(x, y, scene.rho(camera, x, y));
  }
  return map;
}

}  // namespace egofocus::test
