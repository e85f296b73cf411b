#include "kernels/requant.hpp"
#include "requant_rows.hpp"

namespace egofocus::test {

void requant_rows_avx512(const RequantArrays& a) {
  const __m256i zero = _mm256_set1_epi16(static_cast<short>(a.zero));
  for (std::int32_t i = 0; i < a.n; i += 16) {
    const __m256i lanes = requant_s16_avx512(_mm512_loadu_si512(a.acc + i), _mm512_loadu_ps(a.scale + i));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(a.s16 + i), lanes);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(a.u8 + i), narrow_u8_avx512(lanes, zero));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(a.s8 + i), narrow_s8_avx512(lanes, zero));
  }
}

}  // namespace egofocus::test
