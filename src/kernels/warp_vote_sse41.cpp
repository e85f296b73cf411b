#include <smmintrin.h>

#include "kernels/warp_vote_x86.hpp"

namespace egofocus {
namespace {

/// For each set of lanes, the byte shuffle that brings them first: the compression that SSE lacks.
struct LaneOrder {
  alignas(16) std::uint8_t shuffle[16][16];
  std::uint8_t lanes[16];
};

constexpr LaneOrder make_lane_order() noexcept {
  LaneOrder order{};
  for (unsigned set = 0; set < 16; ++set) {
    for (unsigned lane = 0; lane < 4; ++lane) {
      if ((set >> lane & 1u) == 0) continue;
      for (unsigned byte = 0; byte < 4; ++byte) {
        order.shuffle[set][4 * order.lanes[set] + byte] = static_cast<std::uint8_t>(4 * lane + byte);
      }
      ++order.lanes[set];
    }
  }
  return order;
}

constexpr LaneOrder kLaneOrder = make_lane_order();

inline int set_of(__m128i lanes) noexcept {
  return _mm_movemask_ps(_mm_castsi128_ps(lanes));
}

/// Writes 4 lanes, the first of them those of `lanes`; returns how many those are.
inline std::int32_t store_lanes(std::int32_t* to, __m128i value, __m128i lanes) noexcept {
  const int set = set_of(lanes);
  const __m128i shuffle = _mm_load_si128(reinterpret_cast<const __m128i*>(kLaneOrder.shuffle[set]));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_shuffle_epi8(value, shuffle));
  return kLaneOrder.lanes[set];
}

inline __m128i load(const std::int32_t* from) noexcept {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
}

inline __m128i load_bytes(const std::uint8_t* from) noexcept {
  std::int32_t four = 0;
  __builtin_memcpy(&four, from, 4);
  return _mm_cvtepu8_epi32(_mm_cvtsi32_si128(four));
}

FoundRuns find_runs(const WarpVote& vote, std::int32_t first, std::int32_t count, std::int32_t k_first,
                    std::int32_t planes, std::int32_t* runs) noexcept {
  // One lane is row << 16 | column: a single unsigned 16-bit minimum checks both bounds (negative ones wrap
  // to large), a single multiply-add makes row * width + column.
  const __m128i last = _mm_set1_epi32((vote.height - 1) << 16 | (vote.width - 1));
  const __m128i pitch = _mm_set1_epi32(vote.width << 16 | 1);
  const __m128i half = _mm_set1_epi32(0x8000);
  const __m128i no_cell = _mm_set1_epi32(kNoCell);
  const __m128i none = _mm_set1_epi32(-1);
  const __m128i k0 = _mm_set1_epi32(k_first);
  std::int32_t* out = runs;
  std::int32_t landed = 0;
  for (std::int32_t i = first; i < first + count; i += 4) {
    const __m128i du = load(vote.du_q16 + i);
    const __m128i dv = load(vote.dv_q16 + i);
    __m128i u = _mm_add_epi32(_mm_add_epi32(load(vote.u_q16 + i), half), _mm_mullo_epi32(k0, du));
    __m128i v = _mm_add_epi32(_mm_add_epi32(load(vote.v_q16 + i), half), _mm_mullo_epi32(k0, dv));
    const __m128i k_end = load_bytes(vote.k_end + i);
    __m128i run = no_cell;
    for (std::int32_t h = 0; h < planes; ++h) {
      const __m128i pixel = _mm_blend_epi16(_mm_srli_epi32(u, 16), v, 0xaa);
      const __m128i inside = _mm_cmpeq_epi32(_mm_min_epu16(pixel, last), pixel);
      const __m128i lands = _mm_and_si128(inside, _mm_cmpgt_epi32(k_end, _mm_set1_epi32(k_first + h)));
      landed += kLaneOrder.lanes[set_of(lands)];
      const __m128i cell = _mm_blendv_epi8(no_cell, _mm_slli_epi32(_mm_madd_epi16(pixel, pitch), 4), lands);
      const __m128i stays = _mm_cmpeq_epi32(cell, _mm_and_si128(run, no_cell));
      out += store_lanes(out, run, _mm_andnot_si128(stays, _mm_cmpgt_epi32(run, none)));
      run = _mm_or_si128(_mm_blendv_epi8(cell, run, stays), _mm_set1_epi32(1 << h));
      u = _mm_add_epi32(u, du);
      v = _mm_add_epi32(v, dv);
    }
    out += store_lanes(out, run, _mm_cmpgt_epi32(run, none));
  }
  return {static_cast<std::int32_t>(out - runs), landed};
}

}  // namespace

std::int64_t warp_vote_u8_sse41(const WarpVote& vote) noexcept {
  return warp_vote_by_runs(vote, {find_runs, add_runs_x86, fold_row_x86});
}

}  // namespace egofocus
