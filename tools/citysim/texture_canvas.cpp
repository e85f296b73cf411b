#include "citysim/texture_canvas.hpp"

namespace egofocus::citysim {
namespace {

constexpr int kSide = Canvas::kSide;

}  // namespace

void Canvas::fill(int x0, int y0, int width, int height, float to) {
  for (int y = y0; y < y0 + height; ++y) {
    for (int x = x0; x < x0 + width; ++x) at(x, y) = to;
  }
}

void Canvas::add(int x0, int y0, int width, int height, float more) {
  for (int y = y0; y < y0 + height; ++y) {
    for (int x = x0; x < x0 + width; ++x) at(x, y) += more;
  }
}

void Canvas::spot(int cx, int cy, int radius, float more) {
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      const float r = static_cast<float>(x * x + y * y) / static_cast<float>(radius * radius);
      if (r < 1.0f) at(cx + x, cy + y) += more * (1.0f - r) * (1.0f - r);
    }
  }
}

void add_octave(Canvas& canvas, int cells, float gain, Random& random) {
  std::vector<float> lattice(static_cast<std::size_t>(cells * cells));
  for (float& value : lattice) value = static_cast<float>(random.uniform(-1, 1));
  const int step = kSide / cells;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int cx = x / step;
      const int cy = y / step;
      const auto smooth = [step](int at) {
        const float f = (static_cast<float>(at) + 0.5f) / static_cast<float>(step);
        return f * f * (3.0f - 2.0f * f);
      };
      const float fx = smooth(x % step);
      const float fy = smooth(y % step);
      const auto node = [&](int i, int j) {
        return lattice[static_cast<std::size_t>((j % cells) * cells + i % cells)];
      };
      const float top = node(cx, cy) + fx * (node(cx + 1, cy) - node(cx, cy));
      const float bottom = node(cx, cy + 1) + fx * (node(cx + 1, cy + 1) - node(cx, cy + 1));
      canvas.at(x, y) += gain * (top + fy * (bottom - top));
    }
  }
}

void add_noise(Canvas& canvas, float gain, float roughness, Random& random) {
  float octave = gain;
  for (int cells = 4; cells <= 256; cells *= 2, octave *= roughness)
    add_octave(canvas, cells, octave, random);
}

void add_blobs(Canvas& canvas, int count, int largest, Random& random) {
  for (int i = 0; i < count; ++i) {
    const int radius =
        2 + static_cast<int>(static_cast<double>(largest) * random.uniform() * random.uniform());
    const float tone = static_cast<float>(random.uniform(-0.9, 0.9));
    const int y = static_cast<int>(random.below(kSide));
    const int x = static_cast<int>(random.below(kSide));
    canvas.spot(x, y, radius, tone);
  }
}

}  // namespace egofocus::citysim
