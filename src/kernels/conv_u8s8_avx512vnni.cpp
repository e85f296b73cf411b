#include <immintrin.h>

#include "kernels/conv_u8s8_blocks.hpp"
#include "kernels/conv_u8s8_few.hpp"
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

template <ConvEpilogue kEpilogue>
void leave_as(const ConvLeaving& leaving) noexcept {
  const __m512i most = _mm512_set1_epi32(127);
  const __m512i least = kEpilogue == ConvEpilogue::kSmall ? _mm512_set1_epi32(-128) : _mm512_setzero_si512();
  for (std::int32_t o = 0; o < leaving.outputs; o += 16) {
    const std::int32_t left = leaving.outputs - o;
    const __mmask16 valid = static_cast<__mmask16>(left >= 16 ? 0xffff : (1 << left) - 1);
    const __m512 scale = _mm512_load_ps(leaving.scale + o);
    for (std::int32_t p = 0; p < leaving.pixels; ++p) {
      const __m512i acc = _mm512_load_si512(leaving.sums + p * leaving.row + o);
      std::uint8_t* out = leaving.output + p * leaving.output_step;
      if constexpr (kEpilogue == ConvEpilogue::kScore) {
        _mm256_mask_storeu_epi16(out + 2 * o, valid, requant_s16_avx512(acc, scale));
      } else {
        __m512i r = requant_s32_avx512(acc, scale);
        if constexpr (kEpilogue == ConvEpilogue::kAdd) {
          const std::uint8_t* from = leaving.addend + p * leaving.addend_step + o;
          r = _mm512_add_epi32(r, _mm512_cvtepu8_epi32(_mm_maskz_loadu_epi8(valid, from)));
        }
        r = _mm512_min_epi32(_mm512_max_epi32(r, least), most);
        _mm_mask_storeu_epi8(out + o, valid, _mm512_cvtepi32_epi8(r));
      }
    }
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
  if (conv_has_few(conv)) return conv_u8s8_few_avx512vnni(conv);
  conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
