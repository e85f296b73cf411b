#include <immintrin.h>

#include "mac_peak.hpp"

namespace egofocus::bench {
namespace {

using Register = __m512i;

inline Register step(Register sum, Register bytes, Register weights) noexcept {
  return _mm512_dpbusd_epi32(sum, bytes, weights);
}

}  // namespace
}  // namespace egofocus::bench

#include "mac_peak.inc"

std::int64_t egofocus::bench::mac_peak_avx512vnni(std::int32_t rounds) {
  return run_steps(rounds);
}
