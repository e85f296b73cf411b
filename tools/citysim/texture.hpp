// Procedural surface patterns: periodic squares of reflectance with their coarser levels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "citysim/random.hpp"

namespace egofocus::citysim {

using sim::Random;

enum class Pattern : std::uint8_t {
  kBlank,  ///< nearly nothing: what an event camera does not see
  kNoise,  ///< 1/f noise
  kBlobs,  ///< soft spots of many sizes
  kStripes,
  kBricks,
  kTiles,
  kText,    ///< lines of letter-like marks
  kFacade,  ///< windows in rows on a plain or rough wall
  kPlanks,
  kAsphalt,  ///< fine grain with cracks and stains
  kFoliage,
  kChecker,
  kBooks,  ///< upright bands of many widths, some with marks
  kClouds,
};

/// Reflectance 0..1 as u16 (65535 is 1), square, periodic. Level l has side >> l texels.
class Texture {
 public:
  static constexpr int kSide = 512;
  static constexpr int kLevels = 10;

  /// `contrast` 0..1 scales the deviations from the mean reflectance `mean`.
  static Texture make(Pattern pattern, double mean, double contrast, Random random);

  [[nodiscard]] const std::uint16_t* level(int l) const { return texels_.data() + offset(l); }

  /// Start of level l in one array of all levels.
  static constexpr std::size_t offset(int l) {
    std::size_t at = 0;
    for (int i = 0; i < l; ++i)
      at += static_cast<std::size_t>(kSide >> i) * static_cast<std::size_t>(kSide >> i);
    return at;
  }

 private:
  explicit Texture(std::span<const float> reflectance);
  std::vector<std::uint16_t> texels_;
};

/// The bare pattern, kSide^2 values, mean near 0, most within [-1, 1].
std::vector<float> draw_pattern(Pattern pattern, Random& random);

}  // namespace egofocus::citysim
