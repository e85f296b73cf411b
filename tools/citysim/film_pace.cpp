#include "citysim/film_pace.hpp"

#include <algorithm>

#include "citysim/motion_field.hpp"
#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

constexpr int kSampleStep = 4;  // px

float root(float square) {
  return static_cast<float>(square_root(static_cast<double>(square)));
}

}  // namespace

FilmPace pace_of(const World& world, const Optics& optics, const View& view, std::int64_t t_us) {
  const RigidState camera = world.camera_at(1e-6 * static_cast<double>(t_us));
  float v[3];
  float w[3];
  for (std::size_t k = 0; k < 3; ++k) {
    v[k] = static_cast<float>(camera.velocity_m_s[k]);
    w[k] = static_cast<float>(camera.rate_rad_s[k]);
  }
  const float f = static_cast<float>(world.camera.intrinsics.fx_px);
  FilmPace pace;
  std::vector<float> squares;
  for (int row = 0; row < optics.tiles_down(); ++row) {
    for (int column = 0; column < optics.tiles_across(); ++column) {
      const Optics::Tile& tile = optics.tile(column, row);
      float fastest = 0;
      for (int i = kSampleStep / 2; i < Optics::kTileHeight; i += kSampleStep) {
        const int at_y = row * Optics::kTileHeight + i;
        if (at_y >= optics.height()) break;
        for (int j = kSampleStep / 2; j < Optics::kTileWidth; j += kSampleStep) {
          const int at_x = column * Optics::kTileWidth + j;
          if (at_x >= optics.width()) break;
          const std::size_t at = static_cast<std::size_t>(at_y * optics.width() + at_x);
          const float x = tile.x[i * Optics::kTileWidth + j];
          const float y = tile.y[i * Optics::kTileWidth + j];
          const float rho = view.inverse_depth[at];
          const auto [vx, vy] = motion_field(x, y, rho, v, w);
          float square = vx * vx + vy * vy;
          const std::int32_t object = view.object[at];
          if (object >= 0 && world.scene.objects[static_cast<std::size_t>(object)].moves) {
            const Vec3& own = world.scene.objects[static_cast<std::size_t>(object)].velocity_m_s;
            const float sum = root(square) + rho * static_cast<float>(square_root(dot(own, own)));
            square = sum * sum;
          }
          squares.push_back(square);
          fastest = std::max(fastest, square);
        }
      }
      pace.tile.push_back(f * root(fastest));
    }
  }
  const auto top = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() * 99 / 100);
  std::nth_element(squares.begin(), top, squares.end());
  pace.fast = static_cast<double>(f * root(*top));
  return pace;
}

void widen(FilmPace& pace, const Optics& optics) {
  const int across = optics.tiles_across();
  const int down = optics.tiles_down();
  std::vector<float> out(pace.tile.size(), 0.0f);
  for (int row = 0; row < down; ++row) {
    for (int column = 0; column < across; ++column) {
      float& widest = out[static_cast<std::size_t>(row * across + column)];
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, down - 1); ++y) {
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, across - 1); ++x)
          widest = std::max(widest, pace.tile[static_cast<std::size_t>(y * across + x)]);
      }
    }
  }
  pace.tile.swap(out);
}

}  // namespace egofocus::citysim
