// THE rounding rule: how an int32 accumulator becomes s16, u8 or s8. There is no other one in the library,
// and training quantises against this one. docs/kernels-requant.md has the candidates and why this one was
// chosen.
//
//   p = float(acc) * scale        two IEEE binary32 operations, each rounded to nearest, ties to even
//   r = p rounded to an integer, ties to even
//   s16 = clamp(r, -32768, 32767)
//   u8  = clamp(s16 + zero, 0, 255)          s8 = clamp(s16 + zero, -128, 127)
//
// numpy: r = np.rint(acc.astype(np.float32) * np.float32(scale)). The same bits everywhere, as binary32 is:
// accumulators beyond 2^24 are rounded to 24 significant bits first, by the rule and not by accident. Ranges:
// 2^-40 <= scale < 1, so that p never leaves int32 and never becomes subnormal (which 32-bit NEON flushes);
// any acc; |zero| <= 255. Rounding mode: the default one of each thread, to nearest.
// The vector forms are bodies for ISA files: static, of fixed width, lane i in, lane i out.
// Thread: any. RT: yes.
#pragma once

#include <cstdint>

#if defined(__SSE4_1__)
#include <immintrin.h>
#elif defined(__ARM_NEON)
#include <arm_neon.h>
#endif

namespace egofocus {

// --- the meaning
// -----------------------------------------------------------------------------------------------

static inline std::int32_t clamp_s32(std::int32_t value, std::int32_t low, std::int32_t high) noexcept {
  return value < low ? low : (value > high ? high : value);
}

static inline std::int16_t requant_s16(std::int32_t acc, float scale) noexcept {
  const float p = static_cast<float>(acc) * scale;
  // Every clamp from 32768 to 2^22 leaves the result as it is; within 2^22 adding 1.5 * 2^23 leaves no
  // fraction bits.
  constexpr float kBeyond = 40000.0f;
  constexpr float kNoFraction = 12582912.0f;
  const float near = p < -kBeyond ? -kBeyond : (p > kBeyond ? kBeyond : p);
  const float rounded = (near + kNoFraction) - kNoFraction;
  return static_cast<std::int16_t>(clamp_s32(static_cast<std::int32_t>(rounded), -32768, 32767));
}

static inline std::uint8_t requant_u8(std::int32_t acc, float scale, std::int32_t zero) noexcept {
  return static_cast<std::uint8_t>(clamp_s32(requant_s16(acc, scale) + zero, 0, 255));
}

static inline std::int8_t requant_s8(std::int32_t acc, float scale, std::int32_t zero) noexcept {
  return static_cast<std::int8_t>(clamp_s32(requant_s16(acc, scale) + zero, -128, 127));
}

// --- SSE4.1: 8 lanes -> s16, 16 lanes -> 8 bits
// ----------------------------------------------------------------
#if defined(__SSE4_1__)

static inline __m128i requant_s16_sse41(__m128i acc0, __m128i acc1, __m128 scale0, __m128 scale1) noexcept {
  const __m128i r0 = _mm_cvtps_epi32(_mm_mul_ps(_mm_cvtepi32_ps(acc0), scale0));
  const __m128i r1 = _mm_cvtps_epi32(_mm_mul_ps(_mm_cvtepi32_ps(acc1), scale1));
  return _mm_packs_epi32(r0, r1);
}

/// zero: the zero point in every s16 lane.
static inline __m128i narrow_u8_sse41(__m128i low, __m128i high, __m128i zero) noexcept {
  return _mm_packus_epi16(_mm_adds_epi16(low, zero), _mm_adds_epi16(high, zero));
}

static inline __m128i narrow_s8_sse41(__m128i low, __m128i high, __m128i zero) noexcept {
  return _mm_packs_epi16(_mm_adds_epi16(low, zero), _mm_adds_epi16(high, zero));
}

#endif
// --- AVX2: 16 lanes -> s16, 32 lanes -> 8 bits; packing works on 128-bit halves, the permutation puts them
// in order -
#if defined(__AVX2__)

static inline __m256i requant_s16_avx2(__m256i acc0, __m256i acc1, __m256 scale0, __m256 scale1) noexcept {
  const __m256i r0 = _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_cvtepi32_ps(acc0), scale0));
  const __m256i r1 = _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_cvtepi32_ps(acc1), scale1));
  return _mm256_permute4x64_epi64(_mm256_packs_epi32(r0, r1), 0xd8);
}

static inline __m256i narrow_u8_avx2(__m256i low, __m256i high, __m256i zero) noexcept {
  const __m256i packed = _mm256_packus_epi16(_mm256_adds_epi16(low, zero), _mm256_adds_epi16(high, zero));
  return _mm256_permute4x64_epi64(packed, 0xd8);
}

static inline __m256i narrow_s8_avx2(__m256i low, __m256i high, __m256i zero) noexcept {
  const __m256i packed = _mm256_packs_epi16(_mm256_adds_epi16(low, zero), _mm256_adds_epi16(high, zero));
  return _mm256_permute4x64_epi64(packed, 0xd8);
}

#endif
// --- AVX-512: 16 lanes -> s16 -> 8 bits
// ------------------------------------------------------------------------
#if defined(__AVX512BW__) && defined(__AVX512VL__)

/// r before its clamp, for who clamps to less than s16 anyhow.
static inline __m512i requant_s32_avx512(__m512i acc, __m512 scale) noexcept {
  return _mm512_cvtps_epi32(_mm512_mul_ps(_mm512_cvtepi32_ps(acc), scale));
}

static inline __m256i requant_s16_avx512(__m512i acc, __m512 scale) noexcept {
  return _mm512_cvtsepi32_epi16(requant_s32_avx512(acc, scale));
}

static inline __m128i narrow_u8_avx512(__m256i lanes, __m256i zero) noexcept {
  const __m256i moved = _mm256_adds_epi16(lanes, zero);
  return _mm256_cvtusepi16_epi8(_mm256_max_epi16(moved, _mm256_setzero_si256()));
}

static inline __m128i narrow_s8_avx512(__m256i lanes, __m256i zero) noexcept {
  return _mm256_cvtsepi16_epi8(_mm256_adds_epi16(lanes, zero));
}

#endif
// --- NEON: 8 lanes -> s16, 16 lanes -> 8 bits
// ------------------------------------------------------------------
#if defined(__ARM_NEON)

/// Ties to even; without an instruction for it (32-bit), by the addition of the scalar meaning: the integer
/// then stands in the low bits of the sum.
static inline int32x4_t round_even_neon(float32x4_t p) noexcept {
#if defined(__aarch64__)
  return vcvtnq_s32_f32(p);
#else
  const float32x4_t near = vminq_f32(vmaxq_f32(p, vdupq_n_f32(-40000.0f)), vdupq_n_f32(40000.0f));
  const float32x4_t no_fraction = vdupq_n_f32(12582912.0f);
  return vsubq_s32(vreinterpretq_s32_f32(vaddq_f32(near, no_fraction)), vreinterpretq_s32_f32(no_fraction));
#endif
}

static inline int16x8_t requant_s16_neon(int32x4_t acc0, int32x4_t acc1, float32x4_t scale0,
                                         float32x4_t scale1) noexcept {
  const int32x4_t r0 = round_even_neon(vmulq_f32(vcvtq_f32_s32(acc0), scale0));
  const int32x4_t r1 = round_even_neon(vmulq_f32(vcvtq_f32_s32(acc1), scale1));
  return vcombine_s16(vqmovn_s32(r0), vqmovn_s32(r1));
}

static inline uint8x16_t narrow_u8_neon(int16x8_t low, int16x8_t high, int16x8_t zero) noexcept {
  return vcombine_u8(vqmovun_s16(vqaddq_s16(low, zero)), vqmovun_s16(vqaddq_s16(high, zero)));
}

static inline int8x16_t narrow_s8_neon(int16x8_t low, int16x8_t high, int16x8_t zero) noexcept {
  return vcombine_s8(vqmovn_s16(vqaddq_s16(low, zero)), vqmovn_s16(vqaddq_s16(high, zero)));
}

#endif

}  // namespace egofocus
