#include <immintrin.h>

#include "mac_peak.hpp"

namespace egofocus::bench {
namespace {

using Register = __m256i;

inline Register step(Register sum, Register bytes, Register weights) noexcept {
  const __m256i pairs = _mm256_maddubs_epi16(bytes, weights);
  return _mm256_add_epi32(sum, _mm256_madd_epi16(pairs, _mm256_set1_epi16(1)));
}

}  // namespace
}  // namespace egofocus::bench

#include "mac_peak.inc"

std::int64_t egofocus::bench::mac_peak_avx2(std::int32_t rounds) {
  return run_steps(rounds);
}
