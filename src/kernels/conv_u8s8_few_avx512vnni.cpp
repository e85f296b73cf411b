#include <immintrin.h>

#include "kernels/conv_u8s8_few_avx512vnni.hpp"
#include "kernels/requant.hpp"

namespace egofocus {
namespace {

using Wide = __m512i;
constexpr int kWideSums = 16;  // of 32 registers; the inputs of as many pixels, a weight
constexpr int kWidePass = 8;   // outputs at a time

inline Wide wide_load(const void* from) noexcept {
  return _mm512_loadu_si512(from);
}
inline void wide_store(void* to, Wide a) noexcept {
  _mm512_storeu_si512(to, a);
}
inline Wide wide_dword(std::int32_t value) noexcept {
  return _mm512_set1_epi32(value);
}
inline Wide wide_byte(int value) noexcept {
  return _mm512_set1_epi8(static_cast<char>(value));
}
inline Wide wide_four_bytes(const std::int8_t* from) noexcept {
  std::int32_t four = 0;
  __builtin_memcpy(&four, from, 4);
  return _mm512_set1_epi32(four);
}
inline __m128i load_16(const std::uint8_t* from) noexcept {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
}
inline Wide wide_load_16s(const std::uint8_t* from, std::int64_t step) noexcept {
  const __m256i low = _mm256_inserti128_si256(_mm256_castsi128_si256(load_16(from)), load_16(from + step), 1);
  const __m256i high =
      _mm256_inserti128_si256(_mm256_castsi128_si256(load_16(from + 2 * step)), load_16(from + 3 * step), 1);
  return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1);
}
inline Wide wide_dot4(Wide acc, Wide bytes, Wide weights) noexcept {
  return _mm512_dpbusd_epi32(acc, bytes, weights);
}
inline Wide wide_add32(Wide a, Wide b) noexcept {
  return _mm512_add_epi32(a, b);
}
inline Wide wide_even32(Wide a, Wide b) noexcept {
  return _mm512_castps_si512(_mm512_shuffle_ps(_mm512_castsi512_ps(a), _mm512_castsi512_ps(b), 0x88));
}
inline Wide wide_odd32(Wide a, Wide b) noexcept {
  return _mm512_castps_si512(_mm512_shuffle_ps(_mm512_castsi512_ps(a), _mm512_castsi512_ps(b), 0xdd));
}
inline Wide wide_low32(Wide a, Wide b) noexcept {
  return _mm512_unpacklo_epi32(a, b);
}
inline Wide wide_high32(Wide a, Wide b) noexcept {
  return _mm512_unpackhi_epi32(a, b);
}
inline Wide wide_low64(Wide a, Wide b) noexcept {
  return _mm512_unpacklo_epi64(a, b);
}
inline Wide wide_high64(Wide a, Wide b) noexcept {
  return _mm512_unpackhi_epi64(a, b);
}
inline Wide wide_packs32(Wide a, Wide b) noexcept {
  return _mm512_packs_epi32(a, b);
}
inline Wide wide_packs16(Wide a, Wide b) noexcept {
  return _mm512_packs_epi16(a, b);
}
inline Wide wide_max8(Wide a, Wide b) noexcept {
  return _mm512_max_epi8(a, b);
}
inline Wide wide_transpose4x4(Wide bytes) noexcept {
  return _mm512_shuffle_epi8(
      bytes, _mm512_broadcast_i32x4(_mm_setr_epi8(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15)));
}
inline Wide wide_permute(Wide a, Wide from) noexcept {
  return _mm512_permutexvar_epi32(from, a);
}
inline void wide_zip32(Wide& a, Wide& b) noexcept {
  const Wide low = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  const Wide high = _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
  const Wide first = _mm512_permutex2var_epi32(a, low, b);
  b = _mm512_permutex2var_epi32(a, high, b);
  a = first;
}
inline Wide wide_requant(Wide acc, float scale) noexcept {
  return requant_s32_avx512(acc, _mm512_set1_ps(scale));
}
inline void wide_store_s16(std::uint8_t* to, std::int64_t step, Wide r) noexcept {
  alignas(32) std::uint8_t local[32];
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(step == 2 ? to : local), _mm512_cvtsepi32_epi16(r));
  if (step == 2) return;
  for (int p = 0; p < 16; ++p) __builtin_memcpy(to + p * step, local + 2 * p, 2);
}

}  // namespace
}  // namespace egofocus

#include "kernels/conv_u8s8_few.inc"

bool egofocus::conv_u8s8_few_avx512vnni(const ConvU8S8& conv) noexcept {
  return conv_by_few(conv, kConvPacking_avx512vnni);
}
