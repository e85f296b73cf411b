#include "kernels/requant.hpp"
#include "requant_candidates.hpp"

namespace egofocus::bench {
namespace {

inline __m256i load(const void* from) {
  return _mm256_loadu_si256(static_cast<const __m256i*>(from));
}

inline void store(std::uint8_t* to, const __m256i (&r)[4]) {
  const __m256i low = _mm256_permute4x64_epi64(_mm256_packs_epi32(r[0], r[1]), 0xd8);
  const __m256i high = _mm256_permute4x64_epi64(_mm256_packs_epi32(r[2], r[3]), 0xd8);
  const __m256i packed = _mm256_permute4x64_epi64(_mm256_packus_epi16(low, high), 0xd8);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), packed);
}

/// High dwords of (a * b + round) for all eight lanes.
inline __m256i high_product(__m256i a, __m256i b, __m256i round) {
  const __m256i even = _mm256_add_epi64(_mm256_mul_epi32(a, b), round);
  const __m256i odd =
      _mm256_add_epi64(_mm256_mul_epi32(_mm256_srli_epi64(a, 32), _mm256_srli_epi64(b, 32)), round);
  return _mm256_blend_epi16(_mm256_srli_epi64(even, 32), odd, 0xcc);
}

inline __m256i wide(__m256i acc, __m256i multiplier) {
  return _mm256_srai_epi32(high_product(acc, multiplier, _mm256_set1_epi64x(std::int64_t{1} << 38)), 7);
}

/// Multiplier positive: the product cannot saturate.
inline __m256i doubled(__m256i acc, __m256i multiplier, __m256i shift) {
  const __m256i high =
      high_product(_mm256_slli_epi32(acc, 1), multiplier, _mm256_set1_epi64x(std::int64_t{1} << 31));
  const __m256i down = _mm256_sub_epi32(_mm256_setzero_si256(), shift);
  const __m256i round = _mm256_srli_epi32(_mm256_sllv_epi32(_mm256_set1_epi32(1), down), 1);
  return _mm256_srav_epi32(_mm256_add_epi32(high, round), down);
}

}  // namespace

void requant_wide_avx2(const RequantLoad& w) noexcept {
  for (std::int32_t i = 0; i < w.n; i += 32) {
    __m256i r[4];
    for (int q = 0; q < 4; ++q) r[q] = wide(load(w.acc + i + 8 * q), load(w.multiplier + i + 8 * q));
    store(w.out + i, r);
  }
}

void requant_double_avx2(const RequantLoad& w) noexcept {
  for (std::int32_t i = 0; i < w.n; i += 32) {
    __m256i r[4];
    for (int q = 0; q < 4; ++q) {
      r[q] = doubled(load(w.acc + i + 8 * q), load(w.multiplier + i + 8 * q), load(w.shift + i + 8 * q));
    }
    store(w.out + i, r);
  }
}

void requant_float_avx2(const RequantLoad& w) noexcept {
  const __m256i zero = _mm256_setzero_si256();
  for (std::int32_t i = 0; i < w.n; i += 32) {
    __m256i s[2];
    for (int q = 0; q < 2; ++q) {
      const std::int32_t at = i + 16 * q;
      s[q] = requant_s16_avx2(load(w.acc + at), load(w.acc + at + 8), _mm256_loadu_ps(w.scale + at),
                              _mm256_loadu_ps(w.scale + at + 8));
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(w.out + i), narrow_u8_avx2(s[0], s[1], zero));
  }
}

void requant_narrow_avx2(const RequantLoad& w) noexcept {
  for (std::int32_t i = 0; i < w.n; i += 32) {
    __m256i s[2];
    for (int q = 0; q < 2; ++q) {
      const std::int32_t at = i + 16 * q;
      const __m256i acc =
          _mm256_permute4x64_epi64(_mm256_packs_epi32(_mm256_srai_epi32(load(w.acc + at), 4),
                                                      _mm256_srai_epi32(load(w.acc + at + 8), 4)),
                                   0xd8);
      const __m256i product = _mm256_mulhrs_epi16(acc, load(w.multiplier16 + at));
      s[q] = _mm256_srai_epi16(_mm256_adds_epi16(product, _mm256_set1_epi16(64)), 7);
    }
    const __m256i packed = _mm256_permute4x64_epi64(_mm256_packus_epi16(s[0], s[1]), 0xd8);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(w.out + i), packed);
  }
}

}  // namespace egofocus::bench
