#include "recording/depth_picture.hpp"

#include <algorithm>
#include <cassert>
#include <vector>

namespace egofocus::recording {
namespace {

// Nine colours of rising brightness, from night blue over violet, red and orange to light yellow; linear in
// between.
constexpr Rgb kStops[9] = {{18, 22, 84},  {48, 34, 138},  {98, 38, 158},  {150, 42, 146}, {196, 58, 112},
                           {228, 92, 70}, {246, 138, 40}, {252, 192, 50}, {252, 250, 150}};
constexpr Rgb kUnknown{40, 40, 40};
constexpr Rgb kOn{200, 40, 30};
constexpr Rgb kOff{40, 80, 190};

constexpr std::uint8_t mix(int a, int b, int weight_of_b, int full) noexcept {
  return static_cast<std::uint8_t>((a * (full - weight_of_b) + b * weight_of_b + full / 2) / full);
}

[[maybe_unused]] std::size_t area(std::int32_t width, std::int32_t height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

}  // namespace

Rgb depth_colour(std::uint8_t value) noexcept {
  const int position = value * 8;
  const int stop = std::min(position / 255, 7);
  const int weight = position - stop * 255;
  const Rgb& a = kStops[stop];
  const Rgb& b = kStops[stop + 1];
  return {mix(a.r, b.r, weight, 255), mix(a.g, b.g, weight, 255), mix(a.b, b.b, weight, 255)};
}

std::uint16_t nearest_inverse_depth(std::span<const std::uint16_t> inverse_depth,
                                    std::span<const std::uint8_t> confidence) {
  std::vector<std::uint16_t> known;
  for (std::size_t i = 0; i < inverse_depth.size() && i < confidence.size(); ++i) {
    if (confidence[i] > 0) known.push_back(inverse_depth[i]);
  }
  if (known.empty()) return 1;
  const std::size_t rank = known.size() - 1 - known.size() / 100;
  std::nth_element(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(rank), known.end());
  return std::max<std::uint16_t>(known[rank], 1);
}

RgbPicture depth_picture(std::int32_t width_px, std::int32_t height_px,
                         std::span<const std::uint16_t> inverse_depth,
                         std::span<const std::uint8_t> confidence, std::uint16_t nearest) {
  assert(nearest > 0);
  assert(inverse_depth.size() == area(width_px, height_px) && confidence.size() == inverse_depth.size());
  RgbPicture picture(width_px, height_px, kUnknown);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    if (confidence[i] == 0) continue;
    const std::uint32_t level = std::min<std::uint32_t>(255u * inverse_depth[i] / nearest, 255u);
    picture.pixels[i] = depth_colour(static_cast<std::uint8_t>(level));
  }
  return picture;
}

RgbPicture event_picture(std::int32_t width_px, std::int32_t height_px, std::span<const Event> events) {
  RgbPicture picture(width_px, height_px, {255, 255, 255});
  for (const Event& event : events) {
    if (event.x < width_px && event.y < height_px) picture.at(event.x, event.y) = event.polarity ? kOn : kOff;
  }
  return picture;
}

GreyPicture confidence_picture(std::int32_t width_px, std::int32_t height_px,
                               std::span<const std::uint8_t> confidence) {
  assert(confidence.size() == area(width_px, height_px));
  GreyPicture picture(width_px, height_px);
  std::copy(confidence.begin(), confidence.end(), picture.pixels.begin());
  return picture;
}

}  // namespace egofocus::recording
