#include <immintrin.h>

#include "kernels/warp_vote_x86.hpp"

namespace egofocus {
namespace {

/// For each set of lanes, their numbers first: the compression that AVX2 lacks. Eight 4-bit numbers, lowest
/// first.
struct LaneOrder {
  std::uint32_t of_set[256];
};

constexpr LaneOrder make_lane_order() noexcept {
  LaneOrder order{};
  for (std::uint32_t set = 0; set < 256; ++set) {
    std::uint32_t position = 0;
    for (std::uint32_t lane = 0; lane < 8; ++lane) {
      if ((set >> lane & 1u) != 0) order.of_set[set] |= lane << (4 * position++);
    }
  }
  return order;
}

constexpr LaneOrder kLaneOrder = make_lane_order();

/// Writes 8 lanes, the first of them those of `lanes`; returns how many those are.
inline std::int32_t store_lanes(std::int32_t* to, __m256i value, __m256i lanes) noexcept {
  const unsigned set = static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(lanes)));
  const __m256i packed = _mm256_set1_epi32(static_cast<int>(kLaneOrder.of_set[set]));
  // The permutation looks at the low 3 bits of a lane only.
  const __m256i order = _mm256_srlv_epi32(packed, _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32(value, order));
  return __builtin_popcount(set);
}

inline __m256i load(const std::int32_t* from) noexcept {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
}

FoundRuns find_runs(const WarpVote& vote, std::int32_t first, std::int32_t count, std::int32_t k_first,
                    std::int32_t planes, std::int32_t* runs) noexcept {
  // One lane is row << 16 | column: a single unsigned 16-bit minimum checks both bounds (negative ones wrap
  // to large), a single multiply-add makes row * width + column.
  const __m256i last = _mm256_set1_epi32((vote.height - 1) << 16 | (vote.width - 1));
  const __m256i pitch = _mm256_set1_epi32(vote.width << 16 | 1);
  const __m256i half = _mm256_set1_epi32(0x8000);
  const __m256i no_cell = _mm256_set1_epi32(kNoCell);
  const __m256i none = _mm256_set1_epi32(-1);
  const __m256i k0 = _mm256_set1_epi32(k_first);
  std::int32_t* out = runs;
  std::int32_t landed = 0;
  for (std::int32_t i = first; i < first + count; i += 8) {
    const __m256i du = load(vote.du_q16 + i);
    const __m256i dv = load(vote.dv_q16 + i);
    __m256i u = _mm256_add_epi32(_mm256_add_epi32(load(vote.u_q16 + i), half), _mm256_mullo_epi32(k0, du));
    __m256i v = _mm256_add_epi32(_mm256_add_epi32(load(vote.v_q16 + i), half), _mm256_mullo_epi32(k0, dv));
    const __m256i k_end =
        _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(vote.k_end + i)));
    __m256i run = no_cell;
    for (std::int32_t h = 0; h < planes; ++h) {
      const __m256i pixel = _mm256_blend_epi16(_mm256_srli_epi32(u, 16), v, 0xaa);
      const __m256i inside = _mm256_cmpeq_epi32(_mm256_min_epu16(pixel, last), pixel);
      const __m256i lands =
          _mm256_and_si256(inside, _mm256_cmpgt_epi32(k_end, _mm256_set1_epi32(k_first + h)));
      landed += __builtin_popcount(static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(lands))));
      const __m256i cell =
          _mm256_blendv_epi8(no_cell, _mm256_slli_epi32(_mm256_madd_epi16(pixel, pitch), 4), lands);
      const __m256i stays = _mm256_cmpeq_epi32(cell, _mm256_and_si256(run, no_cell));
      out += store_lanes(out, run, _mm256_andnot_si256(stays, _mm256_cmpgt_epi32(run, none)));
      run = _mm256_or_si256(_mm256_blendv_epi8(cell, run, stays), _mm256_set1_epi32(1 << h));
      u = _mm256_add_epi32(u, du);
      v = _mm256_add_epi32(v, dv);
    }
    out += store_lanes(out, run, _mm256_cmpgt_epi32(run, none));
  }
  return {static_cast<std::int32_t>(out - runs), landed};
}

}  // namespace

std::int64_t warp_vote_u8_avx2(const WarpVote& vote) noexcept {
  return warp_vote_by_runs(vote, {find_runs, add_runs_x86, fold_row_x86});
}

}  // namespace egofocus
