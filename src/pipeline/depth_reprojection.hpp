// A depth map seen from another place: each pixel's point is moved as a rigid world moves, in integers.
#pragma once

#include <cstdint>
#include <span>

#include "egofocus/types.hpp"
#include "pipeline/motion_track.hpp"

namespace egofocus {

/// Pixel (x, y) with inverse depth i (in units of the map's scale) comes to lie at (n_0, n_1) / n_2 with
/// inverse depth i / n_2, where n = matrix (x, y, 1) + i * shift.
struct Reprojection {
  std::int64_t matrix_q32[9];
  std::int64_t shift_q32[3];
  /// The motion's length over the depth of a pixel with i = 1, in shares of the largest allowed; at most 2.
  std::uint32_t travel_q24;
};

/// `motion` takes points from the camera that saw the map to the one that shall. max_travel: above 0, at most
/// 1. Thread: any. RT: yes.
Reprojection reprojection(const MotionKnot& motion, const Intrinsics& grid, double scale_per_m,
                          double max_travel) noexcept;

/// Where a pixel's point comes to lie, before it is rounded to a pixel. Within 0.002 px and half a unit of
/// the formula above. False: behind the camera or within 1/16 of its old depth, outside the grid, or nearer
/// than half of what max_travel allows. Thread: any. RT: yes.
struct Landing {
  std::int32_t u_q16 = 0;
  std::int32_t v_q16 = 0;
  std::uint16_t inverse_depth = 0;   ///< nearest; what does not fit is 65535
  std::uint16_t travel_q8 = 0;       ///< of the largest allowed; from 256 on its depth is no longer known
  std::int64_t reciprocal_q32 = 0;   ///< 1 / n_2
  std::int64_t depth_ratio_q32 = 0;  ///< n_2: depth there / depth here
};
bool land(const Reprojection& by, const Intrinsics& grid, std::int32_t x, std::int32_t y,
          std::uint16_t inverse_depth, Landing& out) noexcept;

/// The map in the new view. Each pixel paints what it has become by the stretch of its surroundings, at least
/// one pixel; the nearest wins, of equals the more confident. Confidence is multiplied by share_q8 / 256 (at
/// most 1) and by 1 - travel, rounded up; a pixel without any of it left hides what lies behind, and has no
/// estimate. Holes of at most 3 px in a row or a column, between two painted pixels, get the farther of the
/// two and the smaller confidence; other pixels that nothing falls on, and where a pixel without an estimate
/// does, have none. `landed`: memory for one value per pixel. All maps: [height * width]; input and output
/// must not overlap. Returns the number of pixels with an estimate. Thread: one. RT: yes, O(pixels).
std::size_t reproject(const Reprojection& by, const Intrinsics& grid, std::uint32_t share_q8,
                      std::span<const std::uint16_t> inverse_depth, std::span<const std::uint8_t> confidence,
                      std::span<std::uint32_t> landed, std::span<std::uint16_t> inverse_depth_out,
                      std::span<std::uint8_t> confidence_out) noexcept;

}  // namespace egofocus
