#include "kernels/requant.hpp"
#include "requant_candidates.hpp"

namespace egofocus::bench {
namespace {

inline __m128i load(const void* from) {
  return _mm_loadu_si128(static_cast<const __m128i*>(from));
}

inline void store(std::uint8_t* to, const __m128i (&r)[4]) {
  const __m128i packed = _mm_packus_epi16(_mm_packs_epi32(r[0], r[1]), _mm_packs_epi32(r[2], r[3]));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), packed);
}

/// High dwords of (a * b + round) for all four lanes.
inline __m128i high_product(__m128i a, __m128i b, __m128i round) {
  const __m128i even = _mm_add_epi64(_mm_mul_epi32(a, b), round);
  const __m128i odd = _mm_add_epi64(_mm_mul_epi32(_mm_srli_epi64(a, 32), _mm_srli_epi64(b, 32)), round);
  return _mm_blend_epi16(_mm_srli_epi64(even, 32), odd, 0xcc);
}

inline __m128i wide(__m128i acc, __m128i multiplier) {
  return _mm_srai_epi32(high_product(acc, multiplier, _mm_set1_epi64x(std::int64_t{1} << 38)), 7);
}

/// Multiplier positive: the product cannot saturate. SSE has no shift per lane: a rounding shift by n >= 2 is
/// the high half of a product with 2^(32 - n), which is made as a float.
inline __m128i doubled(__m128i acc, __m128i multiplier, __m128i shift) {
  const __m128i round = _mm_set1_epi64x(std::int64_t{1} << 31);
  const __m128i high = high_product(_mm_slli_epi32(acc, 1), multiplier, round);
  const __m128i exponent = _mm_slli_epi32(_mm_add_epi32(_mm_set1_epi32(127 + 32), shift), 23);
  return high_product(high, _mm_cvttps_epi32(_mm_castsi128_ps(exponent)), round);
}

}  // namespace

void requant_wide_sse41(const RequantLoad& w) noexcept {
  for (std::int32_t i = 0; i < w.n; i += 16) {
    __m128i r[4];
    for (int q = 0; q < 4; ++q) r[q] = wide(load(w.acc + i + 4 * q), load(w.multiplier + i + 4 * q));
    store(w.out + i, r);
  }
}

void requant_double_sse41(const RequantLoad& w) noexcept {
  for (std::int32_t i = 0; i < w.n; i += 16) {
    __m128i r[4];
    for (int q = 0; q < 4; ++q) {
      r[q] = doubled(load(w.acc + i + 4 * q), load(w.multiplier + i + 4 * q), load(w.shift + i + 4 * q));
    }
    store(w.out + i, r);
  }
}

void requant_float_sse41(const RequantLoad& w) noexcept {
  const __m128i zero = _mm_setzero_si128();
  for (std::int32_t i = 0; i < w.n; i += 16) {
    __m128i s[2];
    for (int q = 0; q < 2; ++q) {
      const std::int32_t at = i + 8 * q;
      s[q] = requant_s16_sse41(load(w.acc + at), load(w.acc + at + 4), _mm_loadu_ps(w.scale + at),
                               _mm_loadu_ps(w.scale + at + 4));
    }
    _mm_storeu_si128(reinterpret_cast<__m128i*>(w.out + i), narrow_u8_sse41(s[0], s[1], zero));
  }
}

void requant_narrow_sse41(const RequantLoad& w) noexcept {
  for (std::int32_t i = 0; i < w.n; i += 16) {
    __m128i s[2];
    for (int q = 0; q < 2; ++q) {
      const std::int32_t at = i + 8 * q;
      const __m128i acc =
          _mm_packs_epi32(_mm_srai_epi32(load(w.acc + at), 4), _mm_srai_epi32(load(w.acc + at + 4), 4));
      const __m128i product = _mm_mulhrs_epi16(acc, load(w.multiplier16 + at));
      s[q] = _mm_srai_epi16(_mm_adds_epi16(product, _mm_set1_epi16(64)), 7);
    }
    _mm_storeu_si128(reinterpret_cast<__m128i*>(w.out + i), _mm_packus_epi16(s[0], s[1]));
  }
}

}  // namespace egofocus::bench
