#include "scrolling_texture.hpp"

#include <cmath>

#include "citysim/random.hpp"

namespace egofocus::citysim {
namespace {

constexpr int kFine = 4;
constexpr int kLength_px = 1024;
constexpr int kLength = kLength_px * kFine;

using sim::Random;

/// Adds smooth noise with one random value each `grid` samples across and each `grid` / kFine rows.
void add_octave(std::vector<double>& log_light, int rows, int grid, double sigma, std::uint64_t seed) {
  const int columns = kLength / grid;
  const auto value = [&](int row, int column) {
    const auto cell =
        static_cast<std::uint64_t>(row) * 100'000 + static_cast<std::uint64_t>(column % columns);
    return Random(seed ^ sim::mix_bits(cell)).normal() * sigma;
  };
  const int row_grid = grid / kFine;
  std::vector<double> above, below;
  for (int y = 0; y < rows; ++y) {
    if (y % row_grid == 0) {
      above.clear();
      below.clear();
      for (int c = 0; c <= columns; ++c) {
        above.push_back(value(y / row_grid, c));
        below.push_back(value(y / row_grid + 1, c));
      }
    }
    const double down = static_cast<double>(y % row_grid) / row_grid;
    for (int x = 0; x < kLength; ++x) {
      const auto c = static_cast<std::size_t>(x / grid);
      const double along = static_cast<double>(x % grid) / grid;
      const double upper = above[c] + (above[c + 1] - above[c]) * along;
      const double lower = below[c] + (below[c + 1] - below[c]) * along;
      log_light[static_cast<std::size_t>(y) * kLength + static_cast<std::size_t>(x)] +=
          upper + (lower - upper) * down;
    }
  }
}

void paint_patches(std::vector<double>& log_light, int rows, Random& random) {
  const int patches = kLength_px * rows / 1500;
  for (int i = 0; i < patches; ++i) {
    const auto width = static_cast<int>(random.log_uniform(4, 90) * kFine);
    const auto height = static_cast<int>(random.log_uniform(4, 90));
    const auto left = static_cast<int>(random.below(kLength));
    const int top = static_cast<int>(random.below(static_cast<std::uint32_t>(rows + 40))) - 20;
    const double reflectance = std::log(random.log_uniform(0.05, 0.9));
    for (int y = std::max(0, top); y < std::min(rows, top + height); ++y) {
      for (int x = left; x < left + width; ++x)
        log_light[static_cast<std::size_t>(y) * kLength + static_cast<std::size_t>(x % kLength)] =
            reflectance;
    }
  }
}

/// The lens and the pixel's aperture: a box of a pixel, twice, along the row.
void blur(std::vector<float>& row) {
  std::vector<float> sharp;
  for (int pass = 0; pass < 2; ++pass) {
    sharp = row;
    for (std::size_t x = 0; x < row.size(); ++x) {
      float sum = 0;
      for (std::size_t k = 0; k < kFine; ++k) sum += sharp[(x + k) % row.size()];
      row[x] = sum / kFine;
    }
  }
}

}  // namespace

ScrollingTexture::ScrollingTexture(int width_px, int height_px, const Look& look, std::uint64_t seed)
    : width_px_(width_px), height_px_(height_px), look_(look) {
  Random random(seed, "scrolling texture");
  std::vector<double> log_light(static_cast<std::size_t>(height_px) * kLength, std::log(0.3));
  paint_patches(log_light, height_px, random);
  for (int grid = 256; grid >= 8; grid /= 2)
    add_octave(log_light, height_px, grid, look.roughness, random.bits());
  std::vector<float> row(kLength);
  for (int y = 0; y < height_px; ++y) {
    for (std::size_t x = 0; x < kLength; ++x)
      row[x] = static_cast<float>(look.illumination *
                                  exponential(log_light[static_cast<std::size_t>(y) * kLength + x]));
    blur(row);
    texture_.insert(texture_.end(), row.begin(), row.end());
  }
}

std::vector<float> ScrollingTexture::picture(double t_s) const {
  std::vector<float> light;
  for (int y = 0; y < height_px_; ++y) {
    const double factor = 3 * y < height_px_ ? 0.4 : (3 * y < 2 * height_px_ ? 1.0 : 1.6);
    const double shift = look_.speed_px_s * factor * t_s * kFine;
    const auto whole = static_cast<std::size_t>(shift);
    const auto part = static_cast<float>(shift - static_cast<double>(whole));
    const float* row = &texture_[static_cast<std::size_t>(y) * kLength];
    for (std::size_t x = 0; x < static_cast<std::size_t>(width_px_); ++x) {
      const float a = row[(whole + x * kFine) % kLength];
      const float b = row[(whole + x * kFine + 1) % kLength];
      light.push_back(a + (b - a) * part);
    }
  }
  return light;
}

}  // namespace egofocus::citysim
