// Light for the sensor where no renderer is wanted: a wall of patches and 1/f noise that scrolls by, in
// bands of different speed, like depths beside a slider.
#pragma once

#include <cstdint>
#include <vector>

namespace egofocus::citysim {

class ScrollingTexture {
 public:
  struct Look {
    double speed_px_s = 70;   ///< of the middle band; the others are 0.4 and 1.6 times as fast
    double illumination = 1;  ///< light of a white patch
    double roughness = 0.12;  ///< 1-sigma of each octave of the noise, in log light
  };
  ScrollingTexture(int width_px, int height_px, const Look& look, std::uint64_t seed);

  /// Linear light of all pixels, row-major.
  [[nodiscard]] std::vector<float> picture(double t_s) const;

 private:
  int width_px_;
  int height_px_;
  Look look_;
  std::vector<float> texture_;  // kFine samples a pixel along the rows, repeating
};

}  // namespace egofocus::citysim
