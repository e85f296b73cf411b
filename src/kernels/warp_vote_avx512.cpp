#include <immintrin.h>

#include "kernels/warp_vote_x86.hpp"

namespace egofocus {
namespace {

FoundRuns find_runs(const WarpVote& vote, std::int32_t first, std::int32_t count, std::int32_t k_first,
                    std::int32_t planes, std::int32_t* runs) noexcept {
  // One lane is row << 16 | column: a single unsigned 16-bit minimum checks both bounds (negative ones wrap
  // to large), a single multiply-add makes row * width + column.
  const __m512i last = _mm512_set1_epi32((vote.height - 1) << 16 | (vote.width - 1));
  const __m512i pitch = _mm512_set1_epi32(vote.width << 16 | 1);
  const __m512i half = _mm512_set1_epi32(0x8000);
  const __m512i no_cell = _mm512_set1_epi32(kNoCell);
  const __m512i k0 = _mm512_set1_epi32(k_first);
  std::int32_t* out = runs;
  std::int32_t landed = 0;
  for (std::int32_t i = first; i < first + count; i += 16) {
    const __m512i du = _mm512_loadu_si512(vote.du_q16 + i);
    const __m512i dv = _mm512_loadu_si512(vote.dv_q16 + i);
    __m512i u = _mm512_add_epi32(_mm512_loadu_si512(vote.u_q16 + i), half);
    __m512i v = _mm512_add_epi32(_mm512_loadu_si512(vote.v_q16 + i), half);
    u = _mm512_add_epi32(u, _mm512_mullo_epi32(k0, du));
    v = _mm512_add_epi32(v, _mm512_mullo_epi32(k0, dv));
    const __m128i k_end = _mm_loadu_si128(reinterpret_cast<const __m128i*>(vote.k_end + i));
    __m512i run = no_cell;
    for (std::int32_t h = 0; h < planes; ++h) {
      const __m512i pixel = _mm512_mask_blend_epi16(0xaaaaaaaau, _mm512_srli_epi32(u, 16), v);
      const __mmask16 inside = _mm512_cmpeq_epi32_mask(_mm512_min_epu16(pixel, last), pixel);
      const __mmask16 lands =
          _mm_mask_cmpgt_epu8_mask(inside, k_end, _mm_set1_epi8(static_cast<char>(k_first + h)));
      landed += __builtin_popcount(lands);
      const __m512i cell = _mm512_mask_slli_epi32(no_cell, lands, _mm512_madd_epi16(pixel, pitch), 4);
      const __mmask16 leaves = _mm512_cmpneq_epi32_mask(cell, _mm512_and_si512(run, no_cell));
      const __mmask16 ends = _mm512_mask_cmpge_epi32_mask(leaves, run, _mm512_setzero_si512());
      _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(ends, run));
      out += __builtin_popcount(ends);
      run = _mm512_or_si512(_mm512_mask_mov_epi32(run, leaves, cell), _mm512_set1_epi32(1 << h));
      u = _mm512_add_epi32(u, du);
      v = _mm512_add_epi32(v, dv);
    }
    const __mmask16 ends = _mm512_cmpge_epi32_mask(run, _mm512_setzero_si512());
    _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(ends, run));
    out += __builtin_popcount(ends);
  }
  return {static_cast<std::int32_t>(out - runs), landed};
}

}  // namespace

std::int64_t warp_vote_u8_avx512(const WarpVote& vote) noexcept {
  return warp_vote_by_runs(vote, {find_runs, add_runs_x86, fold_row_x86});
}

}  // namespace egofocus
