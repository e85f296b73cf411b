#include "pipeline/depth_reprojection.hpp"

#include "core/elementary.hpp"

namespace egofocus {
namespace {

constexpr std::int64_t kOne_q32 = std::int64_t{1} << 32;
constexpr std::int64_t kLeastDepthRatio_q32 = kOne_q32 / 16;
constexpr std::int32_t kMostStretch_q16 = 4 << 16;
constexpr std::int32_t kWidestHole_px = 3;

// What lies on a pixel: nothing; something without an estimate; or, ordered by nearness and then by
// confidence, an inverse depth. Confidence 0 among these hides what is farther, and is no estimate.
constexpr std::uint32_t kNothing = 0;
constexpr std::uint32_t kUnknown = 1;
constexpr std::uint32_t kKnown = 1u << 30;

std::uint32_t pack(std::uint16_t inverse_depth, std::uint32_t confidence) noexcept {
  return kKnown | static_cast<std::uint32_t>(inverse_depth) << 8 | confidence;
}

std::int64_t round_q32(double x) noexcept {
  return static_cast<std::int64_t>(floor_of(x * 0x1p32 + 0.5));
}

/// How much wider the surroundings of a pixel become along one axis: d(n_0 / n_2)/dx = (m_0 - u m_6) / n_2.
std::int32_t stretch_q16(std::int64_t along_q32, std::int64_t depth_q32, std::int32_t position_q16,
                         std::int64_t reciprocal_q32) noexcept {
  std::int64_t slope_q16 = (along_q32 >> 16) - ((position_q16 * depth_q32) >> 32);
  if (slope_q16 < 0) slope_q16 = -slope_q16;
  if (slope_q16 > (16 << 16)) slope_q16 = 16 << 16;  // so that the product fits
  const std::int64_t stretch = (slope_q16 * reciprocal_q32) >> 32;
  if (stretch < (1 << 16)) return 1 << 16;
  return stretch < kMostStretch_q16 ? static_cast<std::int32_t>(stretch) : kMostStretch_q16;
}

/// The pixels whose centres lie in (position - stretch / 2, position + stretch / 2].
struct Reach {
  std::int32_t first;
  std::int32_t last;
};
Reach reach(std::int32_t position_q16, std::int32_t stretch_q16, std::int32_t size) noexcept {
  const std::int32_t first = ((position_q16 - stretch_q16 / 2) >> 16) + 1;
  const std::int32_t last = (position_q16 + stretch_q16 / 2) >> 16;
  return {first > 0 ? first : 0, last < size - 1 ? last : size - 1};
}

/// The side of a hole that is seen at `distance` px or less in one direction.
struct Side {
  std::uint32_t value = kNothing;
  std::int32_t distance_px = 0;
};
Side side(std::span<const std::uint32_t> landed, std::size_t at, std::ptrdiff_t stride,
          std::int32_t room_px) noexcept {
  const std::int32_t farthest = room_px < kWidestHole_px ? room_px : kWidestHole_px;
  for (std::int32_t d = 1; d <= farthest; ++d) {
    const std::uint32_t value =
        landed[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(at) + d * stride)];
    if (value != kNothing) return {value, d};
  }
  return {};
}

/// The farther of two sides with the smaller confidence; kNothing where the hole is open, too wide or beside
/// something without an estimate.
std::uint32_t between(const Side& a, const Side& b) noexcept {
  if (a.value < kKnown || b.value < kKnown || a.distance_px + b.distance_px > kWidestHole_px + 1)
    return kNothing;
  const std::uint32_t farther = a.value < b.value ? a.value : b.value;
  const std::uint32_t other = a.value < b.value ? b.value : a.value;
  return (other & 255) < (farther & 255) ? (farther & ~255u) | (other & 255) : farther;
}

}  // namespace

Reprojection reprojection(const MotionKnot& motion, const Intrinsics& grid, double scale_per_m,
                          double max_travel) noexcept {
  const double(&r)[9] = motion.rotation;
  const double(&c)[3] = motion.centre_m;
  const double focal_px[2] = {grid.fx_px, grid.fy_px};
  const double centre_px[2] = {grid.cx_px, grid.cy_px};
  const double travel = square_root(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) * scale_per_m / max_travel;
  // From 2 on no finite depth is moved at all: the shift may then be as large as it likes.
  const bool moves = travel < 2.0;
  Reprojection by;
  by.travel_q24 = moves ? static_cast<std::uint32_t>(floor_of(travel * 0x1p24 + 0.5)) : 2u << 24;
  for (int row = 0; row < 3; ++row) {
    // Row of K (R, c), then of K R K^-1.
    double k[4];
    for (int column = 0; column < 4; ++column) {
      const double own = column < 3 ? r[3 * row + column] : c[row];
      const double depth = column < 3 ? r[6 + column] : c[2];
      k[column] = row < 2 ? focal_px[row] * own + centre_px[row] * depth : depth;
    }
    const double by_x = k[0] / focal_px[0];
    const double by_y = k[1] / focal_px[1];
    by.matrix_q32[3 * row] = round_q32(by_x);
    by.matrix_q32[3 * row + 1] = round_q32(by_y);
    by.matrix_q32[3 * row + 2] = round_q32(k[2] - by_x * centre_px[0] - by_y * centre_px[1]);
    by.shift_q32[row] = moves ? round_q32(k[3] * scale_per_m) : 0;
  }
  return by;
}

// No product overflows: check_camera() keeps f within 0.08 and 30 widths of at most 1280 px, so |matrix|
// stays below 2^17 (its last row below 2^5), and i * shift, of pixels that travel less than twice the largest
// allowed, below 2^18. n_2 is at least 1/16 where it divides, and then the point is inside the grid.
bool land(const Reprojection& by, const Intrinsics& grid, std::int32_t x, std::int32_t y,
          std::uint16_t inverse_depth, Landing& out) noexcept {
  const std::uint64_t travel_q8 = (static_cast<std::uint64_t>(inverse_depth) * by.travel_q24) >> 16;
  if (travel_q8 >= 512) return false;
  const std::int64_t(&m)[9] = by.matrix_q32;
  const std::int64_t n_2 = m[6] * x + m[7] * y + m[8] + inverse_depth * by.shift_q32[2];
  if (n_2 < kLeastDepthRatio_q32) return false;
  const std::int64_t n_0 = m[0] * x + m[1] * y + m[2] + inverse_depth * by.shift_q32[0];
  if (n_0 <= -n_2 || n_0 >= n_2 * grid.width_px) return false;
  const std::int64_t n_1 = m[3] * x + m[4] * y + m[5] + inverse_depth * by.shift_q32[1];
  if (n_1 <= -n_2 || n_1 >= n_2 * grid.height_px) return false;
  out.depth_ratio_q32 = n_2;
  out.reciprocal_q32 =
      static_cast<std::int64_t>((std::uint64_t{1} << 56) / ((static_cast<std::uint64_t>(n_2) + 128) >> 8));
  out.u_q16 = static_cast<std::int32_t>(((n_0 >> 16) * out.reciprocal_q32) >> 32);
  out.v_q16 = static_cast<std::int32_t>(((n_1 >> 16) * out.reciprocal_q32) >> 32);
  const std::int64_t nearer = (inverse_depth * out.reciprocal_q32 + kOne_q32 / 2) >> 32;
  out.inverse_depth = static_cast<std::uint16_t>(nearer < 65535 ? nearer : 65535);
  out.travel_q8 = static_cast<std::uint16_t>(travel_q8);
  return true;
}

std::size_t reproject(const Reprojection& by, const Intrinsics& grid, std::uint32_t share_q8,
                      std::span<const std::uint16_t> inverse_depth, std::span<const std::uint8_t> confidence,
                      std::span<std::uint32_t> landed, std::span<std::uint16_t> inverse_depth_out,
                      std::span<std::uint8_t> confidence_out) noexcept {
  const std::int32_t width = grid.width_px;
  const std::int32_t height = grid.height_px;
  for (std::uint32_t& value : landed) value = kNothing;
  std::size_t at = 0;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x, ++at) {
      Landing to;
      const std::uint32_t old = confidence[at];
      // Where something of unknown depth lies is known for a turn alone: as if it were far.
      if (!land(by, grid, x, y, old != 0 ? inverse_depth[at] : std::uint16_t{0}, to)) continue;
      const std::uint32_t left_q16 = share_q8 * (to.travel_q8 < 256 ? 256u - to.travel_q8 : 0u);
      const std::uint32_t value =
          old != 0 ? pack(to.inverse_depth, (old * left_q16 + 65535) >> 16) : kUnknown;
      const Reach columns = reach(
          to.u_q16, stretch_q16(by.matrix_q32[0], by.matrix_q32[6], to.u_q16, to.reciprocal_q32), width);
      const Reach rows = reach(
          to.v_q16, stretch_q16(by.matrix_q32[4], by.matrix_q32[7], to.v_q16, to.reciprocal_q32), height);
      for (std::int32_t v = rows.first; v <= rows.last; ++v) {
        for (std::int32_t u = columns.first; u <= columns.last; ++u) {
          std::uint32_t& pixel = landed[static_cast<std::size_t>(v * width + u)];
          if (value > pixel) pixel = value;
        }
      }
    }
  }
  std::size_t known = 0;
  at = 0;
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x, ++at) {
      std::uint32_t value = landed[at];
      if (value == kNothing) {
        const std::uint32_t row = between(side(landed, at, -1, x), side(landed, at, 1, width - 1 - x));
        const std::uint32_t column =
            between(side(landed, at, -width, y), side(landed, at, width, height - 1 - y));
        value = row == kNothing || (column != kNothing && column < row) ? column : row;
      }
      const auto sure = static_cast<std::uint8_t>(value >= kKnown ? value & 255 : 0);
      confidence_out[at] = sure;
      inverse_depth_out[at] = static_cast<std::uint16_t>(sure != 0 ? (value >> 8) & 65535 : 0);
      known += sure != 0 ? 1 : 0;
    }
  }
  return known;
}

}  // namespace egofocus
