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
  std::vector<Span::Bounds> columns(static_cast<std::size_t>(tiles_across_), {1e9f, -1e9f});
  std::vector<Span::Bounds> rows(static_cast<std::size_t>(tiles_down_), {1e9f, -1e9f});
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
        tile.per_length[i] = static_cast<float>(
            1.0 / square_root(1.0 + direction.x * direction.x + direction.y * direction.y));
        reach_.x = std::max(reach_.x, absolute(direction.x));
        reach_.y = std::max(reach_.y, absolute(direction.y));
      }
      const auto [low_x, high_x] = std::minmax_element(tile.x, tile.x + kTilePixels);
      const auto [low_y, high_y] = std::minmax_element(tile.y, tile.y + kTilePixels);
      tile.low_x = *low_x;
      tile.high_x = *high_x;
      tile.low_y = *low_y;
      tile.high_y = *high_y;
      Span::Bounds& x = columns[static_cast<std::size_t>(column)];
      x = {std::min(x.low, tile.low_x), std::max(x.high, tile.high_x)};
      Span::Bounds& y = rows[static_cast<std::size_t>(row)];
      y = {std::min(y.low, tile.low_y), std::max(y.high, tile.high_y)};
    }
  }
  columns_ = Span(columns);
  rows_ = Span(rows);
}

Optics::Span::Span(const std::vector<Bounds>& bounds) {
  float high = -1e9f;
  low_ = 1e9f;
  for (const Bounds& of : bounds) {
    low_ = std::min(low_, of.low);
    high = std::max(high, of.high);
  }
  cells_per_unit_ = static_cast<float>(kCells - 1) / (high - low_);
  const int count = static_cast<int>(bounds.size());
  first_.assign(kCells + 1, count);
  last_.assign(kCells + 1, -1);
  // Cell 0 lies below all, the last above all; a value may have been rounded into the next one.
  const float width = (high - low_) / static_cast<float>(kCells - 1);
  for (int cell = 0; cell <= kCells; ++cell) {
    const float from = cell == 0 ? -1e9f : low_ + width * (static_cast<float>(cell) - 1.01f);
    const float to = cell == kCells ? 1e9f : low_ + width * (static_cast<float>(cell) + 0.01f);
    for (int i = 0; i < count; ++i) {
      const Bounds& of = bounds[static_cast<std::size_t>(i)];
      int& first = first_[static_cast<std::size_t>(cell)];
      if (of.high >= from) first = std::min(first, i);
      if (of.low <= to) last_[static_cast<std::size_t>(cell)] = i;
    }
  }
}

Optics::TileRange Optics::tiles_in(float low_x, float high_x, float low_y, float high_y) const {
  return {columns_.first(low_x), columns_.last(high_x), rows_.first(low_y), rows_.last(high_y)};
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
