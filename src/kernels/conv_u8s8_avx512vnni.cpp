#include <immintrin.h>

#include "kernels/conv_u8s8_blocks.hpp"
#include "kernels/conv_u8s8_few_avx512vnni.hpp"
#include "kernels/requant.hpp"

namespace egofocus {
namespace {

inline __m512i four_bytes(const std::uint8_t* from) noexcept {
  std::int32_t four = 0;
  __builtin_memcpy(&four, from, 4);
  return _mm512_set1_epi32(four);
}

template <int kPixels, int kTiles>
void sums_of(const ConvBlock& block) noexcept {
  __m512i acc[kPixels][kTiles];
  EGOFOCUS_UNROLL
  for (int t = 0; t < kTiles; ++t) {
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) acc[p][t] = _mm512_load_si512(block.bias + 16 * t);
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
      __m512i w[kTiles];
      EGOFOCUS_UNROLL
      for (int t = 0; t < kTiles; ++t) w[t] = _mm512_load_si512(weights + t * block.tile_stride);
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) {
        const __m512i pixel = four_bytes(input[p / 4] + p % 4 * step);
        EGOFOCUS_UNROLL
        for (int t = 0; t < kTiles; ++t) acc[p][t] = _mm512_dpbusd_epi32(acc[p][t], pixel, w[t]);
      }
      EGOFOCUS_UNROLL
      for (int q = 0; q < kQuads; ++q) input[q] += 4;
      weights += 64;
    }
  }
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) {
    EGOFOCUS_UNROLL
    for (int t = 0; t < kTiles; ++t) _mm512_store_si512(block.sums + 16 * (p * kTiles + t), acc[p][t]);
  }
}

/// Four registers of s32 -> s8 (saturating), one register's after the other's.
inline __m512i as_bytes(__m512i a, __m512i b, __m512i c, __m512i d) noexcept {
  const __m512i mixed = _mm512_packs_epi16(_mm512_packs_epi32(a, b), _mm512_packs_epi32(c, d));
  return _mm512_permutexvar_epi32(_mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15),
                                  mixed);
}

inline __mmask64 first_bytes(std::int32_t count) noexcept {
  return count >= 64 ? ~__mmask64{0} : (__mmask64{1} << count) - 1;
}

/// Of one pixel. An addend is at most 127: adding it to what has been cut to s8 gives the same.
template <ConvEpilogue kEpilogue>
inline void store_bytes(__m512i bytes, __mmask64 valid, const std::uint8_t* addend,
                        std::uint8_t* out) noexcept {
  if constexpr (kEpilogue == ConvEpilogue::kAdd)
    bytes = _mm512_adds_epi8(bytes, _mm512_maskz_loadu_epi8(valid, addend));
  if constexpr (kEpilogue != ConvEpilogue::kSmall) bytes = _mm512_max_epi8(bytes, _mm512_setzero_si512());
  _mm512_mask_storeu_epi8(out, valid, bytes);
}

/// At most four tiles of each pixel from `pixel` on, and from output `first` on.
template <ConvEpilogue kEpilogue, int kTiles>
void leave_tiles(const ConvLeaving& leaving, std::int32_t pixel, std::int32_t first) noexcept {
  const __mmask64 valid = first_bytes(leaving.outputs - first) & first_bytes(16 * kTiles);
  __m512 scale[kTiles];
  for (int t = 0; t < kTiles; ++t) scale[t] = _mm512_load_ps(leaving.scale + first + 16 * t);
  for (std::int32_t p = pixel; p < leaving.pixels; ++p) {
    const std::int32_t* sums = leaving.sums + p * leaving.row + first;
    __m512i r[kTiles];
    for (int t = 0; t < kTiles; ++t) r[t] = requant_s32_avx512(_mm512_load_si512(sums + 16 * t), scale[t]);
    const __m512i bytes = as_bytes(r[0], r[kTiles > 1 ? 1 : 0], r[kTiles > 2 ? 2 : 0], r[kTiles > 3 ? 3 : 0]);
    store_bytes<kEpilogue>(bytes, valid, leaving.addend + p * leaving.addend_step + first,
                           leaving.output + p * leaving.output_step + first);
  }
}

/// One tile of each pixel: four pixels in a register.
template <ConvEpilogue kEpilogue>
void leave_tile(const ConvLeaving& leaving) noexcept {
  const __mmask64 valid = first_bytes(leaving.outputs);
  const bool dense = leaving.outputs == 16 && leaving.output_step == 16 &&
                     (kEpilogue != ConvEpilogue::kAdd || leaving.addend_step == 16);
  const __m512 scale = _mm512_load_ps(leaving.scale);
  std::int32_t p = 0;
  for (; p + 4 <= leaving.pixels; p += 4) {
    __m512i r[4];
    for (int i = 0; i < 4; ++i)
      r[i] = requant_s32_avx512(_mm512_load_si512(leaving.sums + 16 * (p + i)), scale);
    const __m512i bytes = as_bytes(r[0], r[1], r[2], r[3]);
    const std::uint8_t* addend = leaving.addend + p * leaving.addend_step;
    std::uint8_t* out = leaving.output + p * leaving.output_step;
    if (dense) {
      store_bytes<kEpilogue>(bytes, ~__mmask64{0}, addend, out);
      continue;
    }
    const std::int64_t from = leaving.addend_step;
    const std::int64_t to = leaving.output_step;
    store_bytes<kEpilogue>(bytes, valid, addend, out);
    store_bytes<kEpilogue>(_mm512_shuffle_i32x4(bytes, bytes, 1), valid, addend + from, out + to);
    store_bytes<kEpilogue>(_mm512_shuffle_i32x4(bytes, bytes, 2), valid, addend + 2 * from, out + 2 * to);
    store_bytes<kEpilogue>(_mm512_shuffle_i32x4(bytes, bytes, 3), valid, addend + 3 * from, out + 3 * to);
  }
  leave_tiles<kEpilogue, 1>(leaving, p, 0);
}

void leave_scores(const ConvLeaving& leaving) noexcept {
  for (std::int32_t o = 0; o < leaving.outputs; o += 32) {
    const std::int32_t second = o + 16 < leaving.row ? o + 16 : o;
    const __mmask32 valid = static_cast<__mmask32>(first_bytes(leaving.outputs - o));
    const __m512 scale0 = _mm512_load_ps(leaving.scale + o);
    const __m512 scale1 = _mm512_load_ps(leaving.scale + second);
    const __m512i tile_by_tile = _mm512_setr_epi64(0, 2, 4, 6, 1, 3, 5, 7);
    for (std::int32_t p = 0; p < leaving.pixels; ++p) {
      const std::int32_t* sums = leaving.sums + p * leaving.row;
      const __m512i r = _mm512_packs_epi32(requant_s32_avx512(_mm512_load_si512(sums + o), scale0),
                                           requant_s32_avx512(_mm512_load_si512(sums + second), scale1));
      _mm512_mask_storeu_epi16(leaving.output + p * leaving.output_step + 2 * o, valid,
                               _mm512_permutexvar_epi64(tile_by_tile, r));
    }
  }
}

template <ConvEpilogue kEpilogue>
void leave_as(const ConvLeaving& leaving) noexcept {
  if constexpr (kEpilogue == ConvEpilogue::kScore) return leave_scores(leaving);
  switch (leaving.row / 16) {
    case 1:
      return leave_tile<kEpilogue>(leaving);
    case 2:
      return leave_tiles<kEpilogue, 2>(leaving, 0, 0);
    case 3:
      return leave_tiles<kEpilogue, 3>(leaving, 0, 0);
    case 5:
      leave_tiles<kEpilogue, 1>(leaving, 0, 64);
      [[fallthrough]];
    default:
      return leave_tiles<kEpilogue, 4>(leaving, 0, 0);
  }
}

template <int kPixels, int kTiles>
constexpr ConvBlockWidths widths() noexcept {
  return {kPixels,
          kPixels - 1,
          by_memory<sums_of<kPixels, kTiles>, kPixels>,
          by_memory<sums_of<kPixels - 1, kTiles>, kPixels - 1>,
          by_memory<sums_of<kPixels / 2, kTiles>, kPixels / 2>,
          by_memory<sums_of<1, kTiles>, 1>};
}

// 32 registers: the sums, a group's weights, one pixel.
constexpr ConvBody kBody{kConvPacking_avx512vnni,
                         16,
                         5,
                         {widths<16, 1>(), widths<12, 2>(), widths<8, 3>(), widths<6, 4>(), widths<5, 5>()},
                         EGOFOCUS_LEAVE};

}  // namespace

void conv_u8s8_avx512vnni(const ConvU8S8& conv) noexcept {
  if (!conv_u8s8_few_avx512vnni(conv)) conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
