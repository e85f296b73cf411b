#include <immintrin.h>

#include <cstdint>

namespace egofocus {
namespace {

using Wide = __m128i;

inline Wide wide_load(const void* from) noexcept {
  return _mm_loadu_si128(static_cast<const __m128i*>(from));
}
inline void wide_store(void* to, Wide a) noexcept {
  _mm_storeu_si128(static_cast<__m128i*>(to), a);
}

/// 4, 8 or 12 bytes.
inline Wide wide_load_part(const std::uint8_t* from, std::int32_t bytes) noexcept {
  std::int32_t last = 0;
  __builtin_memcpy(&last, from + bytes - 4, 4);
  if (bytes == 4) return _mm_cvtsi32_si128(last);
  const __m128i first = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from));
  return bytes == 8 ? first : _mm_insert_epi32(first, last, 2);
}

inline void wide_store_part(std::uint8_t* to, Wide a, std::int32_t bytes) noexcept {
  if (bytes >= 8) _mm_storel_epi64(reinterpret_cast<__m128i*>(to), a);
  if (bytes == 8) return;
  const std::int32_t last = bytes == 4 ? _mm_cvtsi128_si32(a) : _mm_extract_epi32(a, 2);
  __builtin_memcpy(to + bytes - 4, &last, 4);
}

inline Wide wide_byte(int value) noexcept {
  return _mm_set1_epi8(static_cast<char>(value));
}
inline Wide wide_low8(Wide a, Wide b) noexcept {
  return _mm_unpacklo_epi8(a, b);
}
inline Wide wide_high8(Wide a, Wide b) noexcept {
  return _mm_unpackhi_epi8(a, b);
}
inline Wide wide_low16(Wide a, Wide b) noexcept {
  return _mm_unpacklo_epi16(a, b);
}
inline Wide wide_high16(Wide a, Wide b) noexcept {
  return _mm_unpackhi_epi16(a, b);
}

/// Bytes up to 127: the sums of two products fit 16 bits.
inline Wide wide_dot4(Wide acc, Wide bytes, Wide weights) noexcept {
  return _mm_add_epi32(acc, _mm_madd_epi16(_mm_maddubs_epi16(bytes, weights), _mm_set1_epi16(1)));
}

inline Wide wide_requant(Wide acc, const float* scale) noexcept {
  return _mm_cvtps_epi32(_mm_mul_ps(_mm_cvtepi32_ps(acc), _mm_load_ps(scale)));
}
inline Wide wide_packs32(Wide a, Wide b) noexcept {
  return _mm_packs_epi32(a, b);
}
inline Wide wide_packs16(Wide a, Wide b) noexcept {
  return _mm_packs_epi16(a, b);
}
inline Wide wide_adds8(Wide a, Wide b) noexcept {
  return _mm_adds_epi8(a, b);
}
inline Wide wide_max8(Wide a, Wide b) noexcept {
  return _mm_max_epi8(a, b);
}

}  // namespace
}  // namespace egofocus

#include "kernels/depthwise_u8s8_x86.inc"

namespace egofocus {

void depthwise_u8s8_sse41(const DepthwiseU8S8& conv) noexcept {
  depthwise_by_registers(conv);
}

}  // namespace egofocus
