// Where each pixel of a distorted camera looks, laid out in tiles, as the renderer walks them.
#pragma once

#include <vector>

#include "egofocus/config.hpp"

namespace egofocus::citysim {

class Optics {
 public:
  static constexpr int kTileWidth = 16;
  static constexpr int kTileHeight = 8;
  static constexpr int kTilePixels = kTileWidth * kTileHeight;

  /// Rays of one tile, row by row: direction (x, y, 1) in the camera's frame. Pixels beyond the picture's
  /// edge repeat the last one.
  struct Tile {
    alignas(64) float x[kTilePixels];
    alignas(64) float y[kTilePixels];
    alignas(64) float per_length[kTilePixels];  ///< 1 / |(x, y, 1)|
    float low_x, high_x, low_y, high_y;
  };

  /// Throws std::invalid_argument when the distortion cannot be inverted all over the picture.
  explicit Optics(const CameraModel& camera);

  [[nodiscard]] const CameraModel& camera() const { return camera_; }
  [[nodiscard]] int width() const { return camera_.intrinsics.width_px; }
  [[nodiscard]] int height() const { return camera_.intrinsics.height_px; }
  [[nodiscard]] int tiles_across() const { return tiles_across_; }
  [[nodiscard]] int tiles_down() const { return tiles_down_; }
  [[nodiscard]] const Tile& tile(int column, int row) const {
    return tiles_[static_cast<std::size_t>(row * tiles_across_ + column)];
  }
  /// Tiles that may hold rays within the bounds; empty when first > last.
  struct TileRange {
    int first_column, last_column, first_row, last_row;
  };
  [[nodiscard]] TileRange tiles_in(float low_x, float high_x, float low_y, float high_y) const;
  /// The ray of pixel (u, v), (x, y, 1).
  struct Ray {
    double x;
    double y;
  };
  [[nodiscard]] Ray ray(double u, double v) const;
  /// The largest |x| and |y| of any ray.
  [[nodiscard]] Ray reach() const { return reach_; }

 private:
  CameraModel camera_;
  int tiles_across_;
  int tiles_down_;
  std::vector<Tile> tiles_;
  /// Which columns (or rows) of tiles hold rays with a value between two: looked up in cells.
  class Span {
   public:
    struct Bounds {
      float low, high;
    };
    Span() = default;
    explicit Span(const std::vector<Bounds>& bounds);
    /// The first that reaches `value` or more; the number of them when none does.
    [[nodiscard]] int first(float value) const { return first_[cell(value)]; }
    /// The last that begins at `value` or less; -1 when none does.
    [[nodiscard]] int last(float value) const { return last_[cell(value)]; }

   private:
    static constexpr int kCells = 512;
    [[nodiscard]] std::size_t cell(float value) const {
      const float at = (value - low_) * cells_per_unit_;
      return at > 0 ? (at < kCells - 1 ? static_cast<std::size_t>(at) + 1 : kCells) : 0;
    }
    float low_ = 0;
    float cells_per_unit_ = 0;
    std::vector<int> first_;
    std::vector<int> last_;
  };
  Span columns_;  // by x
  Span rows_;     // by y
  Ray reach_{0, 0};
};

}  // namespace egofocus::citysim
