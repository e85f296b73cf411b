#include <immintrin.h>

#include "mac_peak.hpp"

namespace egofocus::bench {
namespace {

using Register = __m128i;

inline Register step(Register sum, Register bytes, Register weights) noexcept {
  const __m128i pairs = _mm_maddubs_epi16(bytes, weights);
  return _mm_add_epi32(sum, _mm_madd_epi16(pairs, _mm_set1_epi16(1)));
}

}  // namespace
}  // namespace egofocus::bench

#include "mac_peak.inc"

std::int64_t egofocus::bench::mac_peak_sse41(std::int32_t rounds) {
  return run_steps(rounds);
}
