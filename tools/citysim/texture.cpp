#include "citysim/texture.hpp"

#include <algorithm>

namespace egofocus::citysim {

Texture Texture::make(Pattern pattern, double mean, double contrast, Random random) {
  std::vector<float> values = draw_pattern(pattern, random);
  double sum = 0;
  for (const float value : values) sum += static_cast<double>(value);
  const double middle = sum / static_cast<double>(values.size());
  for (float& value : values) {
    // Multiplicative, so that a dark surface has the same contrast in log light as a bright one.
    const double relative = contrast * (static_cast<double>(value) - middle);
    const double factor = relative >= 0 ? 1.0 + relative : 1.0 / (1.0 - 1.6 * relative);
    value = static_cast<float>(std::clamp(mean * factor, 0.012, 0.95));
  }
  return Texture(values);
}

Texture::Texture(std::span<const float> reflectance) {
  texels_.reserve(kTexels);
  std::vector<float> level(reflectance.begin(), reflectance.end());
  for (int l = 0; l < kLevels; ++l) {
    const std::size_t side = static_cast<std::size_t>(kSide >> l);
    const auto code = [&](std::size_t x, std::size_t y) {
      return static_cast<std::uint64_t>(level[(y % side) * side + x % side] * 65535.0f + 0.5f);
    };
    for (std::size_t y = 0; y < side; ++y) {
      for (std::size_t x = 0; x < side; ++x) {
        texels_.push_back(code(x, y) | code(x + 1, y) << 16 | code(x, y + 1) << 32 |
                          code(x + 1, y + 1) << 48);
      }
    }
    if (side == 1) break;
    std::vector<float> half(level.size() / 4);
    for (std::size_t y = 0; y < side / 2; ++y) {
      for (std::size_t x = 0; x < side / 2; ++x) {
        const float* at = &level[2 * y * side + 2 * x];
        half[y * (side / 2) + x] = 0.25f * ((at[0] + at[1]) + (at[side] + at[side + 1]));
      }
    }
    level.swap(half);
  }
}

}  // namespace egofocus::citysim
