// What a camera sees: for each pixel's ray, exactly which polygon is met, its inverse depth, and its light.
//
// Nothing is clipped or resampled: a polygon's edges, its inverse depth and (after division by it) its
// texture coordinates are linear in the ray (x, y), so they are evaluated at the rays themselves, distortion
// and all (homogeneous rasterisation: Olano and Greer, "Triangle Scan Conversion using 2D Homogeneous
// Coordinates", 1997).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "citysim/optics.hpp"
#include "citysim/scene.hpp"

namespace egofocus::citysim {

/// Row-major, one value per pixel.
struct View {
  std::vector<float> light;          ///< linear; lens blur included
  std::vector<float> mains;          ///< what flickers of it, at the lamps' mean; empty where nothing does
  std::vector<float> inverse_depth;  ///< 1/m along the optical axis; 0: nothing, or the sky
  std::vector<std::int32_t> object;  ///< index into Scene::objects; -1: sky
  std::vector<Colour> colour;        ///< only when asked for
};

/// What a call needs besides its result; one for each thread.
class RenderScratch {
 public:
  RenderScratch();
  ~RenderScratch();
  RenderScratch(RenderScratch&&) noexcept;

 private:
  friend class Renderer;
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

struct RenderOptions {
  bool colour = false;
  bool blur = true;                       ///< the lens's
  std::span<const std::uint8_t> tiles{};  ///< those wanted, row by row; of the others the view stays as it is
};

class Renderer {
 public:
  /// Both must outlive the renderer. `blur` 0..0.25: the lens spreads each pixel's light over its neighbours
  /// with weights (blur, 1 - 2 blur, blur) in each direction.
  Renderer(const Scene& scene, const Optics& optics, double blur);

  /// The view from `camera` (camera to world) at `t_s`. Any number of threads at once, each with a scratch of
  /// its own.
  void render(const Pose& camera, double t_s, RenderScratch& scratch, View& view,
              const RenderOptions& options) const;
  void render(const Pose& camera, double t_s, RenderScratch& scratch, View& view) const {
    render(camera, t_s, scratch, view, {});
  }

  /// The lens blurs light that was rendered without.
  void blur(std::vector<float>& light, std::vector<float>& spare) const;

 private:
  void find_hits(const Pose& camera, double t_s, std::span<const std::uint8_t> wanted,
                 RenderScratch& scratch) const;

  const Scene& scene_;
  const Optics& optics_;
  float blur_;
  std::vector<float> headlight_;  ///< along each ray, tile by tile
};

}  // namespace egofocus::citysim
