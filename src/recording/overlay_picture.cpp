#include "recording/overlay_picture.hpp"

#include <cmath>
#include <cstddef>

namespace egofocus::recording {
namespace {

constexpr Rgb kIsoline{0, 150, 60};
constexpr Rgb kOn{230, 40, 30};
constexpr Rgb kOff{40, 80, 230};
constexpr int kUnknown = 0;
constexpr int kSky = 1000;

/// The stretch between two isolines that a depth lies in.
int stretch_of(float depth_m) {
  if (!(depth_m > 0)) return kUnknown;
  if (!std::isfinite(depth_m)) return kSky;
  return 500 + static_cast<int>(std::floor(std::log(static_cast<double>(depth_m)) / std::log(kIsolineStep)));
}

void draw_isolines(const Picture<float>& depth_m, RgbPicture& out) {
  std::vector<int> stretches;
  for (const float depth : depth_m.pixels) stretches.push_back(stretch_of(depth));
  const auto width = static_cast<std::size_t>(depth_m.width_px);
  const auto steps = [&](std::size_t a, std::size_t b) {
    return stretches[a] != stretches[b] && stretches[a] != kUnknown && stretches[b] != kUnknown;
  };
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const bool right = (i + 1) % width != 0 && steps(i, i + 1);
    const bool below = i + width < stretches.size() && steps(i, i + width);
    if (right || below) out.pixels[i] = kIsoline;
  }
}

}  // namespace

RgbPicture overlay_picture(const Intrinsics& grid, const GreyPicture& grey, const Picture<float>& depth_m,
                           std::span<const Event> events, std::int32_t sensor_width_px,
                           std::span<const std::int32_t> grid_pixel) {
  RgbPicture out(grid.width_px, grid.height_px, {255, 255, 255});
  for (std::size_t i = 0; i < grey.pixels.size() && i < out.pixels.size(); ++i) {
    const auto light = static_cast<std::uint8_t>(127 + grey.pixels[i] / 2);
    out.pixels[i] = {light, light, light};
  }
  if (depth_m.pixels.size() == out.pixels.size()) draw_isolines(depth_m, out);
  for (const Event& event : events) {
    const std::size_t at =
        static_cast<std::size_t>(event.y) * static_cast<std::size_t>(sensor_width_px) + event.x;
    if (event.x >= sensor_width_px || at >= grid_pixel.size() || grid_pixel[at] < 0) continue;
    out.pixels[static_cast<std::size_t>(grid_pixel[at])] = event.polarity ? kOn : kOff;
  }
  return out;
}

}  // namespace egofocus::recording
