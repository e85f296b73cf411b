#include "kernels/requant.hpp"
#include "requant_rows.hpp"

namespace egofocus::test {
namespace {

__m128i load(const std::int32_t* from) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
}
void store(void* to, __m128i value) {
  _mm_storeu_si128(static_cast<__m128i*>(to), value);
}

}  // namespace

void requant_rows_sse41(const RequantArrays& a) {
  const __m128i zero = _mm_set1_epi16(static_cast<short>(a.zero));
  for (std::int32_t i = 0; i < a.n; i += 16) {
    const __m128i low = requant_s16_sse41(load(a.acc + i), load(a.acc + i + 4), _mm_loadu_ps(a.scale + i),
                                          _mm_loadu_ps(a.scale + i + 4));
    const __m128i high = requant_s16_sse41(load(a.acc + i + 8), load(a.acc + i + 12),
                                           _mm_loadu_ps(a.scale + i + 8), _mm_loadu_ps(a.scale + i + 12));
    store(a.s16 + i, low);
    store(a.s16 + i + 8, high);
    store(a.u8 + i, narrow_u8_sse41(low, high, zero));
    store(a.s8 + i, narrow_s8_sse41(low, high, zero));
  }
}

}  // namespace egofocus::test
