#include <immintrin.h>

#include "kernels/conv_u8s8_blocks.hpp"
#include "kernels/requant.hpp"

namespace egofocus {
namespace {

inline __m128i four_bytes(const std::uint8_t* from) noexcept {
  std::int32_t four = 0;
  __builtin_memcpy(&four, from, 4);
  return _mm_set1_epi32(four);
}

inline __m128i load(const void* from) noexcept {
  return _mm_load_si128(static_cast<const __m128i*>(from));
}

/// Four outputs a register. Bytes up to 127: the sums of two products fit 16 bits.
template <int kPixels, int kUnits>
void sums_of(const ConvBlock& block) noexcept {
  const __m128i ones = _mm_set1_epi16(1);
  __m128i acc[kPixels][kUnits];
  EGOFOCUS_UNROLL
  for (int u = 0; u < kUnits; ++u) {
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) acc[p][u] = load(block.bias + 4 * u);
  }
  const std::int64_t step = block.pixel_step;
  const std::int8_t* weights = block.weights;
  for (std::int32_t run = 0; run < block.runs->count; ++run) {
    const std::uint8_t* input = block.input + block.runs->offset[run];
    const std::uint8_t* end = input + block.runs->channels;
    for (; input != end; input += 4) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) {
        const __m128i pixel = four_bytes(input + p * step);
        EGOFOCUS_UNROLL
        for (int u = 0; u < kUnits; ++u) {
          const __m128i pairs = _mm_maddubs_epi16(pixel, load(weights + 16 * u));
          acc[p][u] = _mm_add_epi32(acc[p][u], _mm_madd_epi16(pairs, ones));
        }
      }
      weights += 64;
    }
  }
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) {
    EGOFOCUS_UNROLL
    for (int u = 0; u < kUnits; ++u)
      _mm_store_si128(reinterpret_cast<__m128i*>(block.sums + 4 * (p * kUnits + u)), acc[p][u]);
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
  return load(all);
}

/// Eight outputs of one pixel, `count` of them valid.
template <ConvEpilogue kEpilogue>
inline void leave_8(__m128i r, const std::uint8_t* addend, std::uint8_t* out, std::int32_t count) noexcept {
  if constexpr (kEpilogue == ConvEpilogue::kScore) {
    if (count == 8) return _mm_storeu_si128(reinterpret_cast<__m128i*>(out), r);
    store_part(out, r, 2 * count);
  } else {
    __m128i bytes;
    if constexpr (kEpilogue == ConvEpilogue::kSmall) {
      bytes = _mm_packs_epi16(r, r);
    } else {
      __m128i sum = r;
      if constexpr (kEpilogue == ConvEpilogue::kAdd) {
        const __m128i x =
            count == 8 ? _mm_loadl_epi64(reinterpret_cast<const __m128i*>(addend)) : load_part(addend, count);
        sum = _mm_adds_epi16(r, _mm_cvtepu8_epi16(x));
      }
      sum = _mm_min_epi16(sum, _mm_set1_epi16(127));
      bytes = _mm_packus_epi16(sum, sum);
    }
    if (count == 8) return _mm_storel_epi64(reinterpret_cast<__m128i*>(out), bytes);
    store_part(out, bytes, count);
  }
}

template <ConvEpilogue kEpilogue>
void leave_as(const ConvLeaving& leaving) noexcept {
  constexpr std::int32_t kElement = kEpilogue == ConvEpilogue::kScore ? 2 : 1;
  for (std::int32_t o = 0; o < leaving.outputs; o += 8) {
    const std::int32_t left = leaving.outputs - o;
    const std::int32_t count = left < 8 ? left : 8;
    const bool second = o + 4 < leaving.row;
    const __m128 scale0 = _mm_load_ps(leaving.scale + o);
    const __m128 scale1 = second ? _mm_load_ps(leaving.scale + o + 4) : scale0;
    for (std::int32_t p = 0; p < leaving.pixels; ++p) {
      const std::int32_t* sums = leaving.sums + p * leaving.row + o;
      const __m128i acc0 = load(sums);
      const __m128i acc1 = second ? load(sums + 4) : acc0;
      const std::uint8_t* addend =
          kEpilogue == ConvEpilogue::kAdd ? leaving.addend + p * leaving.addend_step + o : nullptr;
      leave_8<kEpilogue>(requant_s16_sse41(acc0, acc1, scale0, scale1), addend,
                         leaving.output + p * leaving.output_step + kElement * o, count);
    }
  }
}

template <int kPixels, int kUnits>
constexpr ConvBlockWidths widths() noexcept {
  return {kPixels,
          kPixels - 1,
          by_memory<sums_of<kPixels, kUnits>, kPixels>,
          by_memory<sums_of<kPixels - 1, kUnits>, kPixels - 1>,
          by_memory<sums_of<kPixels / 2, kUnits>, kPixels / 2>,
          by_memory<sums_of<1, kUnits>, 1>};
}

// 16 registers: the sums, one pixel, the ones, what is between two steps.
constexpr ConvBody kBody{kConvPacking_sse41,
                         4,
                         4,
                         {widths<8, 1>(), widths<6, 2>(), widths<4, 3>(), widths<3, 4>()},
                         EGOFOCUS_LEAVE};

}  // namespace

void conv_u8s8_sse41(const ConvU8S8& conv) noexcept {
  conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
