// A picture in memory: rows from top to bottom, no padding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace egofocus::recording {

struct Rgb {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  bool operator==(const Rgb&) const = default;
};
static_assert(sizeof(Rgb) == 3);

template <typename Pixel>
struct Picture {
  std::int32_t width_px = 0;
  std::int32_t height_px = 0;
  std::vector<Pixel> pixels;  ///< [height * width]

  Picture() = default;
  Picture(std::int32_t width, std::int32_t height, Pixel fill = {})
      : width_px(width),
        height_px(height),
        pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {}

  [[nodiscard]] Pixel& at(std::int32_t x, std::int32_t y) { return pixels[index(x, y)]; }
  [[nodiscard]] const Pixel& at(std::int32_t x, std::int32_t y) const { return pixels[index(x, y)]; }

 private:
  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) + static_cast<std::size_t>(x);
  }
};

using GreyPicture = Picture<std::uint8_t>;
using Grey16Picture = Picture<std::uint16_t>;
using RgbPicture = Picture<Rgb>;

}  // namespace egofocus::recording
