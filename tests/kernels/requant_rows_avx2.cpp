#include "kernels/requant.hpp"
#include "requant_rows.hpp"

namespace egofocus::test {
namespace {

__m256i load(const std::int32_t* from) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
}
void store(void* to, __m256i value) {
  _mm256_storeu_si256(static_cast<__m256i*>(to), value);
}

}  // namespace

void requant_rows_avx2(const RequantArrays& a) {
  const __m256i zero = _mm256_set1_epi16(static_cast<short>(a.zero));
  for (std::int32_t i = 0; i < a.n; i += 32) {
    const __m256i low = requant_s16_avx2(load(a.acc + i), load(a.acc + i + 8), _mm256_loadu_ps(a.scale + i),
                                         _mm256_loadu_ps(a.scale + i + 8));
    const __m256i high =
        requant_s16_avx2(load(a.acc + i + 16), load(a.acc + i + 24), _mm256_loadu_ps(a.scale + i + 16),
                         _mm256_loadu_ps(a.scale + i + 24));
    store(a.s16 + i, low);
    store(a.s16 + i + 16, high);
    store(a.u8 + i, narrow_u8_avx2(low, high, zero));
    store(a.s8 + i, narrow_s8_avx2(low, high, zero));
  }
}

}  // namespace egofocus::test
