#include "citysim/near_limit.hpp"

#include <algorithm>
#include <vector>

#include "citysim/renderer.hpp"

namespace egofocus::citysim {
namespace {

constexpr int kLooks = 24;
constexpr int kWidth = 64;  // of a look; its pixels are as wide in angle as the picture asks for

}  // namespace

double near_limit_m(const Scene& scene, const Trajectory& trajectory, const Mount& mount,
                    const Intrinsics& grid, double share) {
  const double scale = static_cast<double>(kWidth) / grid.width_px;
  const double to_middle = 0.5 * scale - 0.5;  // pixel centres are whole numbers on both grids
  CameraModel camera;
  camera.intrinsics = {kWidth,
                       std::max(1, static_cast<int>(scale * grid.height_px + 0.5)),
                       scale * grid.fx_px,
                       scale * grid.fy_px,
                       scale * grid.cx_px + to_middle,
                       scale * grid.cy_px + to_middle};
  const Optics optics(camera);
  const Renderer renderer(scene, optics, 0);
  RenderScratch scratch;
  View view;
  std::vector<float> inverse_depths;
  for (int i = 0; i < kLooks; ++i) {
    const double t_s = trajectory.duration_s() * (i + 0.5) / kLooks;
    renderer.render(camera_on(trajectory.body_at(t_s), mount).pose, t_s, scratch, view);
    inverse_depths.insert(inverse_depths.end(), view.inverse_depth.begin(), view.inverse_depth.end());
  }
  const auto at = inverse_depths.begin() +
                  static_cast<std::ptrdiff_t>((1.0 - share) * static_cast<double>(inverse_depths.size() - 1));
  std::nth_element(inverse_depths.begin(), at, inverse_depths.end());
  const double depth_m = *at > 0 ? 1.0 / static_cast<double>(*at) : kFarthest_m;
  return floor_of(100 * std::clamp(depth_m, kNearest_m, kFarthest_m) + 0.5) / 100;
}

}  // namespace egofocus::citysim
