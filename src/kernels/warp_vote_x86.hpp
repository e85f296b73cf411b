// Steps of warp_vote that need no more than 128 bits, for the x86 bodies: each compiles its own copy with its
// flags.
#pragma once

#include <immintrin.h>

#include "kernels/warp_vote_runs.hpp"

namespace egofocus {

static inline void add_runs_x86(const std::int32_t* runs, std::int32_t count,
                                std::uint32_t* scratch) noexcept {
  for (std::int32_t j = 0; j < count; ++j) {
    std::uint32_t* cell = scratch + (runs[j] >> 4);
    const __m128i votes = _mm_cvtsi32_si128(static_cast<int>(kRunCounts[runs[j] & 15]));
    const __m128i before = _mm_cvtsi32_si128(static_cast<int>(*cell));
    *cell = static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_adds_epu8(before, votes)));
  }
}

static inline void fold_row_x86(std::uint32_t* cells, std::int32_t columns, std::uint8_t* row,
                                std::int64_t plane_stride, std::int32_t planes) noexcept {
  const __m128i by_plane = _mm_setr_epi8(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
  for (std::int32_t x = 0; x < columns; x += 16) {
    __m128i* from = reinterpret_cast<__m128i*>(cells + x);
    __m128i c[4];
    for (int q = 0; q < 4; ++q) {
      c[q] = _mm_shuffle_epi8(_mm_loadu_si128(from + q), by_plane);
      _mm_storeu_si128(from + q, _mm_setzero_si128());
    }
    const __m128i low01 = _mm_unpacklo_epi32(c[0], c[1]);
    const __m128i low23 = _mm_unpacklo_epi32(c[2], c[3]);
    const __m128i high01 = _mm_unpackhi_epi32(c[0], c[1]);
    const __m128i high23 = _mm_unpackhi_epi32(c[2], c[3]);
    const __m128i votes[4] = {_mm_unpacklo_epi64(low01, low23), _mm_unpackhi_epi64(low01, low23),
                              _mm_unpacklo_epi64(high01, high23), _mm_unpackhi_epi64(high01, high23)};
    for (std::int32_t h = 0; h < planes; ++h) {
      __m128i* to = reinterpret_cast<__m128i*>(row + h * plane_stride + x);
      _mm_storeu_si128(to, _mm_adds_epu8(_mm_loadu_si128(to), votes[h]));
    }
  }
}

}  // namespace egofocus
