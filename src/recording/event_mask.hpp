// Which pixels of the working grid had an event in a tick's window.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "egofocus/config.hpp"
#include "pipeline/working_grid.hpp"

namespace egofocus::recording {

/// For each sensor pixel, row by row, the index of the grid pixel that its undistorted ray is nearest to; -1:
/// none.
[[nodiscard]] std::vector<std::int32_t> grid_pixels(const Config& config);

/// The same of rays that fill_rays() made, and any grid.
[[nodiscard]] std::vector<std::int32_t> grid_pixels(std::span<const Ray> rays, const Intrinsics& grid);

/// Events count as the recording holds them, before the engine's filter and its decimation, each at the grid
/// pixel that its undistorted ray is nearest to. A grid finer than the sensor has pixels that no event
/// reaches.
class EventMask {
 public:
  explicit EventMask(const Config& config);

  /// Events of one more stretch of time, sorted.
  void add(std::span<const Event> events);

  /// One value per grid pixel: 1 where the newest event has t >= begin_us.
  [[nodiscard]] std::vector<std::uint8_t> since(std::int64_t begin_us) const;

 private:
  std::int32_t sensor_width_px_;
  std::vector<std::int32_t> grid_pixel_;  // of each sensor pixel; -1: outside
  std::vector<std::int64_t> newest_us_;   // of each grid pixel
};

}  // namespace egofocus::recording
