#include <immintrin.h>

#include "kernels/conv_u8s8_blocks.hpp"
#include "kernels/conv_u8s8_few.hpp"
#include "kernels/requant.hpp"

namespace egofocus {
namespace {

/// What stays the same over a call. kOutputs of a pixel are computed, conv.out_channels of them leave.
struct FewSetup {
  ConvRuns taps;
  __m512i weights[9][8];  // [tap][output]: a pixel's weights, repeated
  __m512i bias[2];        // four outputs, repeated
  __m512 scale[2];
};

template <int kLanes>
__m512i repeated(const std::int8_t* weights) noexcept {  // [group][16 outputs][4 inputs], from the output on
  std::int32_t group[kLanes];
  for (int g = 0; g < kLanes; ++g) __builtin_memcpy(&group[g], weights + 64 * g, 4);
  if constexpr (kLanes == 1) return _mm512_set1_epi32(group[0]);
  if constexpr (kLanes == 2) return _mm512_set4_epi32(group[1], group[0], group[1], group[0]);
  if constexpr (kLanes == 4) return _mm512_set4_epi32(group[3], group[2], group[1], group[0]);
}

template <int kLanes, int kOutputs>
void prepare(const ConvU8S8& conv, FewSetup& setup) noexcept {
  setup.taps = conv_taps(conv);
  for (std::int32_t tap = 0; tap < setup.taps.count; ++tap) {
    for (int o = 0; o < kOutputs; ++o)
      setup.weights[tap][o] = repeated<kLanes>(conv.packed.weights + 64 * kLanes * tap + 4 * o);
  }
  for (int q = 0; q < 2; ++q) {
    const __m128i* bias = reinterpret_cast<const __m128i*>(conv.packed.bias + 4 * q);
    setup.bias[q] = _mm512_broadcast_i32x4(_mm_load_si128(bias));
    setup.scale[q] = _mm512_broadcast_f32x4(_mm_load_ps(conv.packed.scale + 4 * q));
  }
}

/// Sums of pairs of lanes: those of a in the even lanes, those of b in the odd ones.
inline __m512i add_pairs(__m512i a, __m512i b) noexcept {
  const __m512i straight = _mm512_mask_blend_epi32(0xaaaa, a, b);
  const __m512i crossed = _mm512_mask_blend_epi32(0xaaaa, b, a);
  return _mm512_add_epi32(straight, _mm512_shuffle_epi32(crossed, _MM_PERM_CDAB));
}

/// Four outputs' sums over kLanes lanes a pixel -> the sums of pixel (4 / kLanes) k + j in the quarter k of
/// r[j], output by output.
template <int kLanes>
inline void by_pixel(const __m512i* a, __m512i* r) noexcept {
  if constexpr (kLanes == 1) {
    const __m512i low01 = _mm512_unpacklo_epi32(a[0], a[1]);
    const __m512i low23 = _mm512_unpacklo_epi32(a[2], a[3]);
    const __m512i high01 = _mm512_unpackhi_epi32(a[0], a[1]);
    const __m512i high23 = _mm512_unpackhi_epi32(a[2], a[3]);
    r[0] = _mm512_unpacklo_epi64(low01, low23);
    r[1] = _mm512_unpackhi_epi64(low01, low23);
    r[2] = _mm512_unpacklo_epi64(high01, high23);
    r[3] = _mm512_unpackhi_epi64(high01, high23);
  } else {
    const __m512i pairs01 = add_pairs(a[0], a[1]);
    const __m512i pairs23 = add_pairs(a[2], a[3]);
    const __m512i low = _mm512_unpacklo_epi64(pairs01, pairs23);
    const __m512i high = _mm512_unpackhi_epi64(pairs01, pairs23);
    if constexpr (kLanes == 2) {
      r[0] = low;
      r[1] = high;
    } else {
      r[0] = _mm512_add_epi32(low, high);
    }
  }
}

/// Four outputs of 16 / kLanes pixels, pixel by pixel: s16 in to[0] and, for one lane, to[1].
template <int kLanes>
inline void four_outputs(const __m512i* acc, __m512i bias, __m512 scale, __m512i* to) noexcept {
  __m512i r[4];
  by_pixel<kLanes>(acc, r);
  for (int j = 0; j < 4 / kLanes; ++j) r[j] = requant_s32_avx512(_mm512_add_epi32(r[j], bias), scale);
  if constexpr (kLanes == 4) to[0] = _mm512_zextsi256_si512(_mm512_cvtsepi32_epi16(r[0]));
  if constexpr (kLanes == 2) to[0] = _mm512_packs_epi32(r[0], r[1]);
  if constexpr (kLanes == 1) {
    // Quarter k of a has pixels 4k and 4k + 1, that of b 4k + 2 and 4k + 3.
    const __m512i a = _mm512_packs_epi32(r[0], r[1]);
    const __m512i b = _mm512_packs_epi32(r[2], r[3]);
    to[0] = _mm512_permutex2var_epi64(a, _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11), b);
    to[1] = _mm512_permutex2var_epi64(a, _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15), b);
  }
}

inline __m256i as_bytes(__m512i s16, ConvEpilogue epilogue) noexcept {
  if (epilogue == ConvEpilogue::kSmall) return _mm512_cvtsepi16_epi8(s16);
  const __m512i some = _mm512_max_epi16(s16, _mm512_setzero_si512());
  return _mm512_cvtepi16_epi8(_mm512_min_epi16(some, _mm512_set1_epi16(127)));
}

/// Copies [pixels][kOutputs] elements to where they belong, conv.out_channels of each pixel.
template <int kOutputs>
void store_pixels(const ConvU8S8& conv, const std::uint8_t* from, std::uint8_t* to,
                  std::int32_t pixels) noexcept {
  const std::int32_t element = conv.epilogue == ConvEpilogue::kScore ? 2 : 1;
  const std::int32_t bytes = conv.out_channels * element;
  const std::int64_t step = conv.output_pixel_stride;
  const std::int32_t from_step = kOutputs * element;
  if (bytes == 2) {
    for (std::int32_t p = 0; p < pixels; ++p) __builtin_memcpy(to + p * step, from + p * from_step, 2);
  } else if (bytes == 4) {
    for (std::int32_t p = 0; p < pixels; ++p) __builtin_memcpy(to + p * step, from + p * from_step, 4);
  } else if (bytes == 8) {
    for (std::int32_t p = 0; p < pixels; ++p) __builtin_memcpy(to + p * step, from + p * from_step, 8);
  } else {
    for (std::int32_t p = 0; p < pixels; ++p) {
      for (std::int32_t b = 0; b < bytes; ++b) to[p * step + b] = from[p * from_step + b];
    }
  }
}

template <int kLanes, int kOutputs>
inline void leave_vector(const ConvU8S8& conv, const FewSetup& setup, const __m512i* acc, std::uint8_t* to,
                         std::int32_t pixels) noexcept {
  constexpr int kVectors = kLanes == 1 ? 2 : 1;
  constexpr int kFours = kOutputs / 4;
  const std::int32_t element = conv.epilogue == ConvEpilogue::kScore ? 2 : 1;
  const bool in_place = pixels == 16 / kLanes && conv.out_channels == kOutputs &&
                        conv.output_pixel_stride == kOutputs * element && kLanes != 4;
  alignas(64) std::uint8_t local[256];
  std::uint8_t* staged = in_place ? to : local;
  __m512i s16[kFours][2];
  for (int q = 0; q < kFours; ++q) four_outputs<kLanes>(acc + 4 * q, setup.bias[q], setup.scale[q], s16[q]);
  for (int v = 0; v < kVectors; ++v) {
    if (conv.epilogue == ConvEpilogue::kScore) {
      if constexpr (kFours == 1) {
        _mm512_storeu_si512(staged + 64 * v, s16[0][v]);
      } else {
        const __m512i low = _mm512_setr_epi64(0, 8, 1, 9, 2, 10, 3, 11);
        const __m512i high = _mm512_setr_epi64(4, 12, 5, 13, 6, 14, 7, 15);
        _mm512_storeu_si512(staged + 128 * v, _mm512_permutex2var_epi64(s16[0][v], low, s16[1][v]));
        _mm512_storeu_si512(staged + 128 * v + 64, _mm512_permutex2var_epi64(s16[0][v], high, s16[1][v]));
      }
    } else if constexpr (kFours == 1) {
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(staged + 32 * v), as_bytes(s16[0][v], conv.epilogue));
    } else {
      const __m512i a = _mm512_castsi256_si512(as_bytes(s16[0][v], conv.epilogue));
      const __m512i b = _mm512_castsi256_si512(as_bytes(s16[1][v], conv.epilogue));
      const __m512i zip = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
      _mm512_storeu_si512(staged + 64 * v, _mm512_permutex2var_epi32(a, zip, b));
    }
  }
  if (!in_place) store_pixels<kOutputs>(conv, staged, to, pixels);
}

/// kVectors * 16 / kLanes pixels, `pixels` of them valid.
template <int kLanes, int kOutputs, int kVectors, bool kWhole>
inline void few_block(const ConvU8S8& conv, const FewSetup& setup, const std::uint8_t* input,
                      std::uint8_t* output, std::int32_t pixels) noexcept {
  constexpr std::int32_t kPixels = 16 / kLanes;  // of a register
  __m512i acc[kVectors][kOutputs];
  EGOFOCUS_UNROLL
  for (int v = 0; v < kVectors; ++v) {
    EGOFOCUS_UNROLL
    for (int o = 0; o < kOutputs; ++o) acc[v][o] = _mm512_setzero_si512();
  }
  const __mmask16 valid = static_cast<__mmask16>(kWhole ? 0xffff : (1u << (pixels * kLanes)) - 1);
  for (std::int32_t tap = 0; tap < setup.taps.count; ++tap) {
    const std::uint8_t* from = input + setup.taps.offset[tap];
    __m512i x[kVectors];
    EGOFOCUS_UNROLL
    for (int v = 0; v < kVectors; ++v)
      x[v] = kWhole ? _mm512_loadu_si512(from + 64 * v) : _mm512_maskz_loadu_epi32(valid, from);
    EGOFOCUS_UNROLL
    for (int o = 0; o < kOutputs; ++o) {
      EGOFOCUS_UNROLL
      for (int v = 0; v < kVectors; ++v)
        acc[v][o] = _mm512_dpbusd_epi32(acc[v][o], x[v], setup.weights[tap][o]);
    }
  }
  EGOFOCUS_UNROLL
  for (int v = 0; v < kVectors; ++v)
    leave_vector<kLanes, kOutputs>(conv, setup, acc[v],
                                   output + v * kPixels * std::int64_t{conv.output_pixel_stride},
                                   kWhole ? kPixels : pixels);
}

template <int kLanes, int kOutputs>
void run(const ConvU8S8& conv) noexcept {
  constexpr int kVectors = 16 / kOutputs;
  constexpr std::int32_t kPixels = 16 / kLanes;
  FewSetup setup;
  prepare<kLanes, kOutputs>(conv, setup);
  for (std::int32_t row = conv.first_row; row < conv.first_row + conv.rows; ++row) {
    const std::uint8_t* input = conv.input + std::int64_t{row} * conv.input_row_stride;
    std::uint8_t* output =
        static_cast<std::uint8_t*>(conv.output) + std::int64_t{row} * conv.output_row_stride;
    const auto at = [&conv](std::uint8_t* first, std::int32_t column) {
      return first + column * std::int64_t{conv.output_pixel_stride};
    };
    std::int32_t x = 0;
    for (; x + kVectors * kPixels <= conv.columns; x += kVectors * kPixels)
      few_block<kLanes, kOutputs, kVectors, true>(conv, setup, input + 4 * kLanes * x, at(output, x), 0);
    for (; x + kPixels <= conv.columns; x += kPixels)
      few_block<kLanes, kOutputs, 1, true>(conv, setup, input + 4 * kLanes * x, at(output, x), 0);
    if (x < conv.columns)
      few_block<kLanes, kOutputs, 1, false>(conv, setup, input + 4 * kLanes * x, at(output, x),
                                            conv.columns - x);
  }
}

template <int kLanes>
void run_lanes(const ConvU8S8& conv) noexcept {
  if (conv.out_channels <= 4) return run<kLanes, 4>(conv);
  run<kLanes, 8>(conv);
}

}  // namespace

void conv_u8s8_few_avx512vnni(const ConvU8S8& conv) noexcept {
  switch (conv.in_channels) {
    case 4:
      return run_lanes<1>(conv);
    case 8:
      return run_lanes<2>(conv);
    default:
      return run_lanes<4>(conv);
  }
}

}  // namespace egofocus
