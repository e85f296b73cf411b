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

/// Reflectance 0..1 as u16 (65535 is 1), square, periodic. Level l has side >> l texels; level 0 comes first.
/// Each entry holds a texel (lowest 16 bits), its right neighbour, the one below, and that one's right
/// neighbour, so that a bilinear look-up is one load.
class Texture {
 public:
  static constexpr int kSide = 512;
  static constexpr int kLevels = 10;
  static constexpr std::size_t kTexels = ((std::size_t{1} << 20) - 1) / 3;  ///< of all levels

  /// `contrast` 0..1 scales the deviations from the mean reflectance `mean`.
  static Texture make(Pattern pattern, double mean, double contrast, Random random);

  [[nodiscard]] std::span<const std::uint64_t> texels() const { return texels_; }

  /// Where level l begins: the sum of (side >> i)^2 over i < l, which is (2^20 - 2^(20 - 2 l)) / 3. The exact
  /// division is a product modulo 2^32.
  static constexpr std::uint32_t offset(std::uint32_t l) {
    return ((1u << 20) - (1u << (20 - 2 * l))) * 0xAAAAAAABu;
  }

 private:
  explicit Texture(std::span<const float> reflectance);
  std::vector<std::uint64_t> texels_;
};

/// The bare pattern, kSide^2 values, mean near 0, most within [-1, 1].
std::vector<float> draw_pattern(Pattern pattern, Random& random);

}  // namespace egofocus::citysim
