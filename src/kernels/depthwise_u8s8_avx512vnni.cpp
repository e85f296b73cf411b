#include <immintrin.h>

#include <cstdint>

#include "kernels/requant.hpp"

namespace egofocus {
namespace {

using Wide = __m512i;

inline Wide wide_load(const void* from) noexcept {
  return _mm512_loadu_si512(from);
}
inline void wide_store(void* to, Wide a) noexcept {
  _mm512_storeu_si512(to, a);
}
inline __mmask64 first_bytes(std::int32_t count) noexcept {
  return (__mmask64{1} << count) - 1;
}
inline Wide wide_load_part(const std::uint8_t* from, std::int32_t bytes) noexcept {
  return _mm512_maskz_loadu_epi8(first_bytes(bytes), from);
}
inline void wide_store_part(std::uint8_t* to, Wide a, std::int32_t bytes) noexcept {
  _mm512_mask_storeu_epi8(to, first_bytes(bytes), a);
}

inline Wide wide_byte(int value) noexcept {
  return _mm512_set1_epi8(static_cast<char>(value));
}
inline Wide wide_low8(Wide a, Wide b) noexcept {
  return _mm512_unpacklo_epi8(a, b);
}
inline Wide wide_high8(Wide a, Wide b) noexcept {
  return _mm512_unpackhi_epi8(a, b);
}
inline Wide wide_low16(Wide a, Wide b) noexcept {
  return _mm512_unpacklo_epi16(a, b);
}
inline Wide wide_high16(Wide a, Wide b) noexcept {
  return _mm512_unpackhi_epi16(a, b);
}
inline Wide wide_dot4(Wide acc, Wide bytes, Wide weights) noexcept {
  return _mm512_dpbusd_epi32(acc, bytes, weights);
}
inline Wide wide_requant(Wide acc, const float* scale) noexcept {
  return requant_s32_avx512(acc, _mm512_load_ps(scale));
}
inline Wide wide_packs32(Wide a, Wide b) noexcept {
  return _mm512_packs_epi32(a, b);
}
inline Wide wide_packs16(Wide a, Wide b) noexcept {
  return _mm512_packs_epi16(a, b);
}
inline Wide wide_adds8(Wide a, Wide b) noexcept {
  return _mm512_adds_epi8(a, b);
}
inline Wide wide_max8(Wide a, Wide b) noexcept {
  return _mm512_max_epi8(a, b);
}

}  // namespace
}  // namespace egofocus

#include "kernels/depthwise_u8s8_x86.inc"

namespace egofocus {

void depthwise_u8s8_avx512vnni(const DepthwiseU8S8& conv) noexcept {
  depthwise_by_registers(conv);
}

}  // namespace egofocus
