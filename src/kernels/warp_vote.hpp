// Warp vote: events cast onto the images of warped events (IWE), one image per inverse-depth hypothesis.
#pragma once

#include <cstdint>

#include "kernels/isa.hpp"

namespace egofocus {

/// Operands of one call. For each event i in [0, n) and each hypothesis k in [k_begin, k_begin + k_count):
///   U = (u_q16[i] + k * du_q16[i] + 0x8000) >> 16         (arithmetic shift: nearest pixel, half up)
///   V = (v_q16[i] + k * dv_q16[i] + 0x8000) >> 16
///   if 0 <= U < width and 0 <= V < height and k < k_end[i]:
///     stack[(k - k_begin) * plane_stride + V * row_stride + U] += 1, saturating at 255
///
/// Ranges (the caller's duty; nothing overflows then): |u|, |v|, |u + 63 du|, |v + 63 dv| < 2^30, thus
/// positions within 16384 px and slopes within 2^31 / 63; 0 <= k_begin, 0 <= k_count, k_begin + k_count <=
/// 64; 0 <= width, height <= 16384; width * height <= 2^26; width <= row_stride; height * row_stride <=
/// plane_stride. An event whose trajectory leaves these ranges is left out by the caller with k_end[i] = 0
/// and zero operands. Scratch: one u32 per grid cell, all zero at the call and left all zero; one per thread,
/// reused by all its calls. Without it (null) variants that want it run the scalar loop: the same bytes,
/// slowly. Alignment: that of the element types. Over-read, over-write: none, and padding bytes of rows and
/// planes are left alone. Aliasing: stack and scratch overlap nothing. The stack is added to: clear it first
/// where it is new.
struct WarpVote {
  const std::int32_t* u_q16 = nullptr;   ///< [n] column at hypothesis 0, grid px
  const std::int32_t* v_q16 = nullptr;   ///< [n] row at hypothesis 0, grid px
  const std::int32_t* du_q16 = nullptr;  ///< [n] px per hypothesis
  const std::int32_t* dv_q16 = nullptr;  ///< [n] px per hypothesis
  const std::uint8_t* k_end =
      nullptr;  ///< [n] first hypothesis that puts the point behind the camera; 64: none
  std::int32_t n = 0;
  std::int32_t k_begin = 0;
  std::int32_t k_count = 0;
  std::int32_t width = 0;            ///< px
  std::int32_t height = 0;           ///< px
  std::int32_t row_stride = 0;       ///< bytes
  std::int64_t plane_stride = 0;     ///< bytes
  std::uint8_t* stack = nullptr;     ///< [k_count][height][width]: plane 0 is hypothesis k_begin
  std::uint32_t* scratch = nullptr;  ///< [height][width], dense; see above
};

/// Returns the number of votes that landed inside the grid (saturated ones included).
/// Thread: any; calls with different planes and scratch may run at once. RT: yes, O(n * k_count).
using WarpVoteFunction = std::int64_t(const WarpVote& vote) noexcept;

/// Whether a variant wants its scratch: those that find the runs of an event first (warp_vote_runs.hpp).
constexpr bool wants_scratch(Isa isa) noexcept {
  return isa != Isa::kScalar && isa < Isa::kNeon;
}

#define EGOFOCUS_WARP_VOTE(suffix, isa) WarpVoteFunction warp_vote_u8_##suffix;
#include "kernels/warp_vote.inc"
#undef EGOFOCUS_WARP_VOTE

}  // namespace egofocus
