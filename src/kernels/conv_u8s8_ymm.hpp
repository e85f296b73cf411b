// The body of conv_u8s8 on 256-bit registers, shared by avx2 and avxvnni, which differ in one function: four
// products a lane.
#pragma once

#include <immintrin.h>

#include "kernels/conv_u8s8_blocks.hpp"
#include "kernels/requant.hpp"

namespace egofocus {
namespace {

inline __m256i dot4(__m256i acc, __m256i bytes, __m256i weights) noexcept;

inline __m256i four_bytes(const std::uint8_t* from) noexcept {
  std::int32_t four = 0;
  __builtin_memcpy(&four, from, 4);
  return _mm256_set1_epi32(four);
}

inline __m256i load(const void* from) noexcept {
  return _mm256_load_si256(static_cast<const __m256i*>(from));
}

template <int kPixels, int kTiles>
void sums_of(const ConvBlock& block) noexcept {
  __m256i acc[kPixels][kTiles];
  EGOFOCUS_UNROLL
  for (int t = 0; t < kTiles; ++t) {
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) acc[p][t] = load(block.bias + 8 * t);
  }
  constexpr int kQuads = (kPixels + 3) / 4;
  const std::int64_t step = block.pixel_step;
  const std::int8_t* weights = block.weights;
  for (std::int32_t run = 0; run < block.runs->count; ++run) {
    // One pointer for four pixels: one for each would not fit the general registers.
    const std::uint8_t* input[kQuads];
    EGOFOCUS_UNROLL
    for (int q = 0; q < kQuads; ++q) input[q] = block.input + block.runs->offset[run] + 4 * q * step;
    for (std::int32_t i = 0; i < block.runs->channels; i += 4) {
      __m256i w[kTiles];
      EGOFOCUS_UNROLL
      for (int t = 0; t < kTiles; ++t) w[t] = load(weights + t * block.tile_stride);
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) {
        const __m256i pixel = four_bytes(input[p / 4] + p % 4 * step);
        EGOFOCUS_UNROLL
        for (int t = 0; t < kTiles; ++t) acc[p][t] = dot4(acc[p][t], pixel, w[t]);
      }
      EGOFOCUS_UNROLL
      for (int q = 0; q < kQuads; ++q) input[q] += 4;
      weights += 32;
    }
  }
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) {
    EGOFOCUS_UNROLL
    for (int t = 0; t < kTiles; ++t)
      _mm256_store_si256(reinterpret_cast<__m256i*>(block.sums + 8 * (p * kTiles + t)), acc[p][t]);
  }
}

inline void store_part(std::uint8_t* to, __m128i bytes, std::int32_t count) noexcept {
  const std::int32_t first = _mm_cvtsi128_si32(bytes);
  if (count == 4) {  // what the network's narrow layers have
    __builtin_memcpy(to, &first, 4);
    return;
  }
  if (count == 2) {
    __builtin_memcpy(to, &first, 2);
    return;
  }
  alignas(16) std::uint8_t all[16];
  _mm_store_si128(reinterpret_cast<__m128i*>(all), bytes);
  for (std::int32_t i = 0; i < count; ++i) to[i] = all[i];
}

inline __m128i load_part(const std::uint8_t* from, std::int32_t count) noexcept {
  alignas(16) std::uint8_t all[16] = {};
  for (std::int32_t i = 0; i < count; ++i) all[i] = from[i];
  return _mm_load_si128(reinterpret_cast<const __m128i*>(all));
}

/// 16 outputs of one pixel, `count` of them valid.
template <ConvEpilogue kEpilogue>
inline void leave_16(__m256i r, const std::uint8_t* addend, std::uint8_t* out, std::int32_t count) noexcept {
  const __m128i low = _mm256_castsi256_si128(r);
  const __m128i high = _mm256_extracti128_si256(r, 1);
  if constexpr (kEpilogue == ConvEpilogue::kScore) {
    if (count == 16) return _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), r);
    store_part(out, low, count < 8 ? 2 * count : 16);
    if (count > 8) store_part(out + 16, high, 2 * count - 16);
  } else {
    __m128i bytes;
    if constexpr (kEpilogue == ConvEpilogue::kSmall) {
      bytes = _mm_packs_epi16(low, high);
    } else {
      __m256i sum = r;
      if constexpr (kEpilogue == ConvEpilogue::kAdd) {
        const __m128i x = count == 16 ? _mm_loadu_si128(reinterpret_cast<const __m128i*>(addend))
                                      : load_part(addend, count);
        sum = _mm256_adds_epi16(r, _mm256_cvtepu8_epi16(x));
      }
      sum = _mm256_min_epi16(sum, _mm256_set1_epi16(127));
      bytes = _mm_packus_epi16(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
    }
    if (count == 16) return _mm_storeu_si128(reinterpret_cast<__m128i*>(out), bytes);
    if (count == 8) return _mm_storel_epi64(reinterpret_cast<__m128i*>(out), bytes);
    store_part(out, bytes, count);
  }
}

template <ConvEpilogue kEpilogue>
void leave_as(const ConvLeaving& leaving) noexcept {
  constexpr std::int32_t kElement = kEpilogue == ConvEpilogue::kScore ? 2 : 1;
  for (std::int32_t o = 0; o < leaving.outputs; o += 16) {
    const std::int32_t left = leaving.outputs - o;
    const std::int32_t count = left < 16 ? left : 16;
    const bool second = o + 8 < leaving.row;
    const __m256 scale0 = _mm256_load_ps(leaving.scale + o);
    const __m256 scale1 = second ? _mm256_load_ps(leaving.scale + o + 8) : scale0;
    for (std::int32_t p = 0; p < leaving.pixels; ++p) {
      const std::int32_t* sums = leaving.sums + p * leaving.row + o;
      const __m256i acc0 = load(sums);
      const __m256i acc1 = second ? load(sums + 8) : acc0;
      const std::uint8_t* addend =
          kEpilogue == ConvEpilogue::kAdd ? leaving.addend + p * leaving.addend_step + o : nullptr;
      leave_16<kEpilogue>(requant_s16_avx2(acc0, acc1, scale0, scale1), addend,
                          leaving.output + p * leaving.output_step + kElement * o, count);
    }
  }
}

template <int kPixels, int kTiles>
constexpr ConvBlockWidths widths() noexcept {
  return {kPixels,
          kPixels - 1,
          sums_of<kPixels, kTiles>,
          sums_of<kPixels - 1, kTiles>,
          sums_of<kPixels / 2, kTiles>,
          sums_of<1, kTiles>};
}

}  // namespace
}  // namespace egofocus
