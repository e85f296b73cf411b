#include <algorithm>

#include "citysim/texture.hpp"
#include "citysim/texture_canvas.hpp"

namespace egofocus::citysim {
namespace {

constexpr int kSide = Texture::kSide;

void bricks(Canvas& canvas, Random& random) {
  const int height = 16 << random.below(2);
  const int width = height * (2 + static_cast<int>(random.below(2)));
  const int joint = 1 + static_cast<int>(random.below(3));
  const float mortar = static_cast<float>(random.uniform(-0.6, 0.8));
  canvas.fill(0, 0, kSide, kSide, mortar);
  const int columns = kSide / width;
  for (int row = 0; row * height < kSide; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int shift = (row % 2) * width / 2;
      const int x1 = (column + 1 == columns) ? kSide : (column + 1) * width;
      const float tone = static_cast<float>(random.uniform(-0.35, 0.35));
      canvas.fill(column * width + shift + joint, row * height + joint, x1 - column * width - joint,
                  height - joint, tone);
    }
  }
  add_noise(canvas, 0.15f, 0.7f, random);
}

void tiles(Canvas& canvas, Random& random) {
  const int side = 32 << random.below(3);
  const float joint = static_cast<float>(random.uniform(-0.9, 0.6));
  const float spread = static_cast<float>(random.uniform(0.02, 0.3));
  canvas.fill(0, 0, kSide, kSide, joint);
  for (int y = 0; y < kSide; y += side) {
    for (int x = 0; x < kSide; x += side) {
      canvas.fill(x + 2, y + 2, side - 2, side - 2, spread * static_cast<float>(random.uniform(-1, 1)));
    }
  }
  add_noise(canvas, 0.06f, 0.7f, random);
}

void stripes(Canvas& canvas, Random& random) {
  const bool upright = random.chance(0.5);
  for (int at = 0; at < kSide;) {
    const int width = std::min(6 + static_cast<int>(random.below(60)), kSide - at);
    const float tone = static_cast<float>(random.uniform(-0.8, 0.8));
    if (upright)
      canvas.fill(at, 0, width, kSide, tone);
    else
      canvas.fill(0, at, kSide, width, tone);
    at += width;
  }
  add_noise(canvas, 0.08f, 0.6f, random);
}

void text(Canvas& canvas, Random& random) {
  canvas.fill(0, 0, kSide, kSide, 0.5f);
  for (int y = 8; y < kSide - 24;) {
    const int size = 8 + static_cast<int>(random.below(28));
    const int margin = static_cast<int>(random.below(60));
    const int end = kSide - 8 - static_cast<int>(random.below(120));
    const float ink = static_cast<float>(random.uniform(-1.0, -0.3));
    const int stroke = std::max(1, size / 7);
    for (int x = 8 + margin; x + size < end && y + size < kSide;) {
      if (random.chance(0.16)) {  // a gap between words
        x += size / 2;
        continue;
      }
      const int width = size / 2 + static_cast<int>(random.below(static_cast<std::uint32_t>(size / 4 + 1)));
      for (int part = 0; part < 3; ++part) {  // some strokes of a letter
        switch (random.below(4)) {
          case 0:
            canvas.fill(x, y, stroke, size, ink);
            break;
          case 1:
            canvas.fill(x + width - stroke, y, stroke, size, ink);
            break;
          case 2:
            canvas.fill(x, y + size / 2, width, stroke, ink);
            break;
          default:
            canvas.fill(x, y + (random.chance(0.5) ? 0 : size - stroke), width, stroke, ink);
            break;
        }
      }
      x += width + std::max(2, size / 6);
    }
    y += size + size / 3 + static_cast<int>(random.below(10));
  }
}

void facade(Canvas& canvas, Random& random) {
  if (random.chance(0.5)) add_noise(canvas, 0.25f, 0.75f, random);
  const int columns = 2 + static_cast<int>(random.below(4));
  const int rows = 2 + static_cast<int>(random.below(3));
  const int cell_x = kSide / columns;
  const int cell_y = kSide / rows;
  const int width = static_cast<int>(static_cast<double>(cell_x) * random.uniform(0.3, 0.75));
  const int height = static_cast<int>(static_cast<double>(cell_y) * random.uniform(0.4, 0.75));
  const float frame = static_cast<float>(random.uniform(-0.4, 0.9));
  const int border = 3 + static_cast<int>(random.below(8));
  const bool cross = random.chance(0.6);
  const bool sill = random.chance(0.5);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int x = column * cell_x + (cell_x - width) / 2;
      const int y = row * cell_y + (cell_y - height) / 2;
      canvas.fill(x, y, width, height, frame);
      // Glass is dark, or bright where it mirrors the sky; some have a curtain.
      float glass = static_cast<float>(random.uniform(-1.2, -0.6));
      if (random.chance(0.2)) glass = static_cast<float>(random.uniform(0.1, 0.8));
      canvas.fill(x + border, y + border, width - 2 * border, height - 2 * border, glass);
      if (cross) canvas.fill(x + width / 2 - border / 2, y, border, height, frame);
      if (random.chance(0.3)) canvas.fill(x + border, y + border, width - 2 * border, height / 3, 0.3f);
      if (sill) canvas.fill(x - 6, y + height, width + 12, 5, 0.5f);
    }
  }
  if (random.chance(0.5)) canvas.add(0, kSide - 14, kSide, 14, static_cast<float>(random.uniform(-0.6, 0.6)));
}

void asphalt(Canvas& canvas, Random& random) {
  for (int cells = 64; cells <= 512; cells *= 2) add_octave(canvas, cells, 0.28f, random);
  add_octave(canvas, 8, 0.12f, random);
  for (int i = 0; i < 14; ++i) {  // stains and patches
    const float tone = static_cast<float>(random.uniform(-0.4, 0.25));
    const int radius = 6 + static_cast<int>(random.below(40));
    const int y = static_cast<int>(random.below(kSide));
    const int x = static_cast<int>(random.below(kSide));
    canvas.spot(x, y, radius, tone);
  }
  for (int crack = 0; crack < 5; ++crack) {
    int x = static_cast<int>(random.below(kSide));
    int y = static_cast<int>(random.below(kSide));
    const int length = 60 + static_cast<int>(random.below(300));
    const bool along = random.chance(0.5);
    for (int i = 0; i < length; ++i) {
      canvas.fill(x, y, 2, 2, -0.8f);
      const int wander = static_cast<int>(random.below(3)) - 1;
      x += along ? 1 : wander;
      y += along ? wander : 1;
    }
  }
}

void planks(Canvas& canvas, Random& random) {
  const int width = 32 << random.below(2);
  for (int x = 0; x < kSide; x += width) {
    const float tone = static_cast<float>(random.uniform(-0.25, 0.25));
    canvas.fill(x, 0, width, kSide, tone);
    for (int grain = 0; grain < 6; ++grain) {
      const float shade = static_cast<float>(random.uniform(-0.2, 0.1));
      const int at = x + static_cast<int>(random.below(static_cast<std::uint32_t>(width - 2)));
      canvas.add(at, 0, 2, kSide, shade);
    }
    canvas.fill(x, 0, 2, kSide, -0.9f);
    canvas.fill(x, static_cast<int>(random.below(kSide)), width, 2, -0.9f);
  }
  add_noise(canvas, 0.08f, 0.7f, random);
}

void books(Canvas& canvas, Random& random) {
  canvas.fill(0, 0, kSide, kSide, -1.2f);
  constexpr int kShelf = kSide / 4;
  for (int shelf = 0; shelf < 4; ++shelf) {
    canvas.fill(0, shelf * kShelf, kSide, 8, 0.5f);
    for (int x = 0; x < kSide - 30;) {
      const int width = 8 + static_cast<int>(random.below(22));
      const int height = kShelf - 14 - static_cast<int>(random.below(40));
      const int top = (shelf + 1) * kShelf - height;
      canvas.fill(x, top, width - 1, height, static_cast<float>(random.uniform(-0.7, 0.9)));
      if (random.chance(0.6)) {
        canvas.fill(x + 2, top + height / 4, width - 5, height / 8,
                    static_cast<float>(random.uniform(-0.9, 0.9)));
      }
      x += width + (random.chance(0.1) ? 25 : 0);
    }
  }
}

void checker(Canvas& canvas, Random& random) {
  const int side = 32 << random.below(3);
  for (int y = 0; y < kSide; y += side) {
    for (int x = 0; x < kSide; x += side) {
      canvas.fill(x, y, side, side, ((x + y) / side) % 2 == 0 ? 0.9f : -0.9f);
    }
  }
}

}  // namespace

std::vector<float> draw_pattern(Pattern pattern, Random& random) {
  Canvas canvas;
  switch (pattern) {
    case Pattern::kBlank:
      add_octave(canvas, 4, 0.02f, random);
      break;
    case Pattern::kNoise:
      add_noise(canvas, 0.5f, static_cast<float>(random.uniform(0.6, 0.95)), random);
      break;
    case Pattern::kBlobs:
      add_blobs(canvas, 500, 40, random);
      break;
    case Pattern::kStripes:
      stripes(canvas, random);
      break;
    case Pattern::kBricks:
      bricks(canvas, random);
      break;
    case Pattern::kTiles:
      tiles(canvas, random);
      break;
    case Pattern::kText:
      text(canvas, random);
      break;
    case Pattern::kFacade:
      facade(canvas, random);
      break;
    case Pattern::kPlanks:
      planks(canvas, random);
      break;
    case Pattern::kAsphalt:
      asphalt(canvas, random);
      break;
    case Pattern::kFoliage:
      add_blobs(canvas, 2500, 16, random);
      add_noise(canvas, 0.2f, 0.8f, random);
      break;
    case Pattern::kChecker:
      checker(canvas, random);
      break;
    case Pattern::kBooks:
      books(canvas, random);
      break;
    case Pattern::kClouds:
      add_noise(canvas, 0.6f, 0.5f, random);
      break;
  }
  return std::move(canvas.value);
}

}  // namespace egofocus::citysim
