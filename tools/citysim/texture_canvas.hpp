// A periodic picture to draw patterns on: their common strokes.
#pragma once

#include <cstddef>
#include <vector>

#include "citysim/texture.hpp"

namespace egofocus::citysim {

/// kSide x kSide values around 0; whatever leaves it on one side comes in on the other.
struct Canvas {
  static constexpr int kSide = Texture::kSide;
  std::vector<float> value =
      std::vector<float>(static_cast<std::size_t>(kSide) * static_cast<std::size_t>(kSide), 0.0f);

  float& at(int x, int y) {
    return value[static_cast<std::size_t>(y & (kSide - 1)) * kSide +
                 static_cast<std::size_t>(x & (kSide - 1))];
  }
  void fill(int x0, int y0, int width, int height, float to);
  void add(int x0, int y0, int width, int height, float more);
  /// Soft: strongest at its centre, nothing at `radius`.
  void spot(int cx, int cy, int radius, float more);
};

/// Value noise: lattice of `cells` x `cells` random values, smooth between, times `gain`.
void add_octave(Canvas& canvas, int cells, float gain, Random& random);
/// Octaves of 4 to 256 cells; each has `roughness` times the gain of the coarser one.
void add_noise(Canvas& canvas, float gain, float roughness, Random& random);
/// Spots of radius 2 to `largest` + 2, mostly small, lighter and darker.
void add_blobs(Canvas& canvas, int count, int largest, Random& random);

}  // namespace egofocus::citysim
