#include "citysim/optics.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/elementary.hpp"
#include "pipeline/working_grid.hpp"

namespace egofocus::citysim {

Optics::Optics(const CameraModel& camera)
    : camera_(camera),
      tiles_across_((camera.intrinsics.width_px + kTileWidth - 1) / kTileWidth),
      tiles_down_((camera.intrinsics.height_px + kTileHeight - 1) / kTileHeight) {
  columns_.resize(static_cast<std::size_t>(tiles_across_), {1e9f, -1e9f});
  rows_.resize(static_cast<std::size_t>(tiles_down_), {1e9f, -1e9f});
  tiles_.resize(static_cast<std::size_t>(tiles_across_) * static_cast<std::size_t>(tiles_down_));
  for (int row = 0; row < tiles_down_; ++row) {
    for (int column = 0; column < tiles_across_; ++column) {
      Tile& tile = tiles_[static_cast<std::size_t>(row * tiles_across_ + column)];
      for (int i = 0; i < kTilePixels; ++i) {
        const int u = std::min(column * kTileWidth + i % kTileWidth, width() - 1);
        const int v = std::min(row * kTileHeight + i / kTileWidth, height() - 1);
        const Ray direction = ray(u, v);
        tile.x[i] = static_cast<float>(direction.x);
        tile.y[i] = static_cast<float>(direction.y);
        reach_.x = std::max(reach_.x, absolute(direction.x));
        reach_.y = std::max(reach_.y, absolute(direction.y));
      }
      const auto [low_x, high_x] = std::minmax_element(tile.x, tile.x + kTilePixels);
      const auto [low_y, high_y] = std::minmax_element(tile.y, tile.y + kTilePixels);
      tile.low_x = *low_x;
      tile.high_x = *high_x;
      tile.low_y = *low_y;
      tile.high_y = *high_y;
      Bounds& x = columns_[static_cast<std::size_t>(column)];
      x = {std::min(x.low, tile.low_x), std::max(x.high, tile.high_x)};
      Bounds& y = rows_[static_cast<std::size_t>(row)];
      y = {std::min(y.low, tile.low_y), std::max(y.high, tile.high_y)};
    }
  }
}

Optics::TileRange Optics::tiles_in(float low_x, float high_x, float low_y, float high_y) const {
  TileRange range{0, tiles_across_ - 1, 0, tiles_down_ - 1};
  while (range.first_column < tiles_across_ &&
         columns_[static_cast<std::size_t>(range.first_column)].high < low_x) {
    ++range.first_column;
  }
  while (range.last_column >= 0 && columns_[static_cast<std::size_t>(range.last_column)].low > high_x)
    --range.last_column;
  while (range.first_row < tiles_down_ && rows_[static_cast<std::size_t>(range.first_row)].high < low_y)
    ++range.first_row;
  while (range.last_row >= 0 && rows_[static_cast<std::size_t>(range.last_row)].low > high_y)
    --range.last_row;
  return range;
}

Optics::Ray Optics::ray(double u, double v) const {
  const Intrinsics& in = camera_.intrinsics;
  Ray out{0, 0};
  if (!undistort(camera_, (u - in.cx_px) / in.fx_px, (v - in.cy_px) / in.fy_px, out.x, out.y)) {
    throw std::invalid_argument("the distortion cannot be inverted all over the picture");
  }
  return out;
}

}  // namespace egofocus::citysim
