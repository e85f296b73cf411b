#include "support/plane_scene.hpp"

#include "citysim/random.hpp"

namespace egofocus::sim {
namespace {

// A texel is about a pixel of this focal length at the depth where the rectangle stands: no aliasing, no
// blur.
constexpr double kFocalPx = 200.0;

double smooth_step(double t) {
  return t * t * (3.0 - 2.0 * t);
}

/// Noise between random values on a periodic lattice of `cell` texels, in [0, 1].
double lattice_noise(int x, int y, int cell, int side, std::uint64_t seed) {
  const int cells = side / cell;
  const auto corner = [=](int i, int j) {
    const auto key = static_cast<std::uint64_t>((j % cells) * cells + i % cells);
    return static_cast<double>(mix_bits(seed * 0x10001u + key) >> 11) * 0x1p-53;
  };
  const int i = x / cell;
  const int j = y / cell;
  const double fx = smooth_step(static_cast<double>(x % cell) / cell);
  const double fy = smooth_step(static_cast<double>(y % cell) / cell);
  const double top = corner(i, j) + fx * (corner(i + 1, j) - corner(i, j));
  const double bottom = corner(i, j + 1) + fx * (corner(i + 1, j + 1) - corner(i, j + 1));
  return top + fy * (bottom - top);
}

/// Blotches with edges about a texel wide: most of the contrast on few lines, as in natural pictures.
double blotch(double noise) {
  const double t = (noise - 0.5) * 12.0 + 0.5;
  return smooth_step(t < 0 ? 0 : (t > 1 ? 1 : t));
}

Rectangle facing(const Vec3& centre, double half_width_m, double half_height_m, double yaw, double pitch) {
  const Mat3 turn = rotation({0, 0, yaw}) * rotation({0, pitch, 0});
  return {centre, turn * Vec3{0, -1, 0}, turn * Vec3{0, 0, 1}, half_width_m, half_height_m};
}

}  // namespace

PlaneScene PlaneScene::standard(std::uint64_t seed) {
  return PlaneScene(
      {facing({3.8, 0, 0}, 1e3, 1e3, 0, 0), facing({1.75, 0.22, -0.30}, 0.42, 0.30, 0.2, 0),
       facing({2.0, -0.78, 0.26}, 0.48, 0.40, -0.2, 0), facing({2.2, 0.45, 0.52}, 0.55, 0.36, 0, -0.15),
       facing({2.6, -0.60, -0.75}, 0.80, 0.45, 0, 0.15), facing({2.9, 1.45, 0.00}, 0.55, 0.90, 0.15, 0)},
      seed);
}

PlaneScene::PlaneScene(std::vector<Rectangle> rectangles, std::uint64_t seed)
    : rectangles_(std::move(rectangles)) {
  for (const Rectangle& rectangle : rectangles_) {
    textures_.push_back(make_texture(kFocalPx / rectangle.centre[0], ++seed));
  }
  look_from({});
}

PlaneScene::Texture PlaneScene::make_texture(double texels_per_m, std::uint64_t seed) {
  Texture texture;
  texture.texels_per_m = texels_per_m;
  for (int y = 0; y < kTextureSide; ++y) {
    for (int x = 0; x < kTextureSide; ++x) {
      const auto noise = [&](int cell) {
        return lattice_noise(x, y, cell, kTextureSide, seed * 64u + static_cast<std::uint64_t>(cell));
      };
      const double level = 0.30 * blotch(noise(16)) + 0.40 * blotch(noise(8)) + 0.40 * blotch(noise(4));
      texture.log_intensity.push_back(static_cast<float>(level));
    }
  }
  return texture;
}

double PlaneScene::Texture::at(double u_m, double v_m) const {
  const double u = u_m * texels_per_m;
  const double v = v_m * texels_per_m;
  const double u0 = floor_of(u);
  const double v0 = floor_of(v);
  const auto wrap = [](double cell) {
    return static_cast<std::size_t>(static_cast<std::int64_t>(cell) & (kTextureSide - 1));
  };
  const auto texel = [this](std::size_t x, std::size_t y) {
    return static_cast<double>(log_intensity[y * kTextureSide + x]);
  };
  const std::size_t x0 = wrap(u0);
  const std::size_t x1 = wrap(u0 + 1);
  const std::size_t y0 = wrap(v0);
  const std::size_t y1 = wrap(v0 + 1);
  const double fu = u - u0;
  const double top = texel(x0, y0) + fu * (texel(x1, y0) - texel(x0, y0));
  const double bottom = texel(x0, y1) + fu * (texel(x1, y1) - texel(x0, y1));
  return top + (v - v0) * (bottom - top);
}

void PlaneScene::look_from(const CameraPose& pose) {
  const Mat3 to_camera = transpose(pose.rotation);
  seen_.clear();
  for (const Rectangle& rectangle : rectangles_) {
    Seen seen;
    seen.centre = to_camera * (rectangle.centre - pose.position);
    seen.right = to_camera * rectangle.right;
    seen.up = to_camera * rectangle.up;
    seen.normal = cross(seen.right, seen.up);
    seen.distance = dot(seen.normal, seen.centre);
    seen_.push_back(seen);
  }
}

Hit PlaneScene::cast(double x, double y) const {
  const Vec3 ray{x, y, 1};
  Hit nearest;
  std::size_t which = 0;
  double best_u = 0;
  double best_v = 0;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const Seen& seen = seen_[i];
    const double slope = dot(seen.normal, ray);
    if (absolute(slope) < 1e-9) continue;
    const double depth = seen.distance / slope;
    if (depth <= 0.01 || (nearest.depth_m > 0 && depth >= nearest.depth_m)) continue;
    const Vec3 on_plane = depth * ray - seen.centre;
    const double u = dot(on_plane, seen.right);
    const double v = dot(on_plane, seen.up);
    if (absolute(u) > rectangles_[i].half_width_m || absolute(v) > rectangles_[i].half_height_m) continue;
    nearest.depth_m = depth;
    which = i;
    best_u = u;
    best_v = v;
  }
  if (nearest.depth_m > 0) nearest.log_intensity = textures_[which].at(best_u, best_v);
  return nearest;
}

}  // namespace egofocus::sim
