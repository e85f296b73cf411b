#include "recording/event_mask.hpp"

#include <cmath>

namespace egofocus::recording {

std::vector<std::int32_t> grid_pixels(const Config& config) {
  const Intrinsics& sensor = config.camera.intrinsics;
  std::vector<Ray> rays(static_cast<std::size_t>(sensor.width_px) *
                        static_cast<std::size_t>(sensor.height_px));
  fill_rays(config.camera, rays);
  return grid_pixels(rays, working_grid(config));
}

std::vector<std::int32_t> grid_pixels(std::span<const Ray> rays, const Intrinsics& grid) {
  std::vector<std::int32_t> pixels;
  pixels.reserve(rays.size());
  for (const Ray& ray : rays) {
    const double u = std::floor(grid.fx_px * static_cast<double>(ray.x) + grid.cx_px + 0.5);
    const double v = std::floor(grid.fy_px * static_cast<double>(ray.y) + grid.cy_px + 0.5);
    const bool inside = u >= 0 && u < grid.width_px && v >= 0 && v < grid.height_px;
    pixels.push_back(inside ? static_cast<std::int32_t>(v) * grid.width_px + static_cast<std::int32_t>(u)
                            : -1);
  }
  return pixels;
}

EventMask::EventMask(const Config& config)
    : sensor_width_px_(config.camera.intrinsics.width_px), grid_pixel_(grid_pixels(config)) {
  const Intrinsics grid = working_grid(config);
  newest_us_.assign(static_cast<std::size_t>(grid.width_px) * static_cast<std::size_t>(grid.height_px),
                    INT64_MIN);
}

void EventMask::add(std::span<const Event> events) {
  for (const Event& event : events) {
    const std::size_t at =
        static_cast<std::size_t>(event.y) * static_cast<std::size_t>(sensor_width_px_) + event.x;
    if (event.x >= sensor_width_px_ || at >= grid_pixel_.size() || grid_pixel_[at] < 0) continue;
    newest_us_[static_cast<std::size_t>(grid_pixel_[at])] = event.t_us;
  }
}

std::vector<std::uint8_t> EventMask::since(std::int64_t begin_us) const {
  std::vector<std::uint8_t> mask(newest_us_.size());
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = newest_us_[i] >= begin_us ? 1 : 0;
  return mask;
}

}  // namespace egofocus::recording
