// Four ways to bring int32 accumulators to u8 (zero point 0), each with a scale per lane. Candidate "float"
// became the rule (src/kernels/requant.hpp); the others stay for the table in docs/kernels-requant.md. Every
// body is one straight loop, so that its instructions can be counted in the object code
// (model_loops.py --count).
#pragma once

#include <cstdint>

namespace egofocus::bench {

inline constexpr std::int32_t kRequantLoop = 32;

struct RequantLoad {
  const std::int32_t* acc;
  const float* scale;              ///< "float"
  const std::int32_t* multiplier;  ///< "wide" and "double": Q31
  const std::int32_t* shift;  ///< "double": negative left shift after the multiplication, as NEON wants it
  const std::int16_t* multiplier16;  ///< "narrow": Q15
  std::uint8_t* out;
  std::int32_t n;  ///< a multiple of kRequantLoop
};

using RequantCandidate = void(const RequantLoad& load) noexcept;

// wide:   (acc * multiplier + 2^38) >> 39 in 64 bits, half up
// double: saturating rounding doubling high multiplication, then a rounding shift, per lane (two roundings)
// float:  binary32 product, nearest even
// narrow: acc >> 4 saturated to s16, 16-bit rounding high multiplication, rounding shift by 7
#define EGOFOCUS_CANDIDATES(isa)                                                             \
  extern "C" RequantCandidate requant_wide_##isa, requant_double_##isa, requant_float_##isa, \
      requant_narrow_##isa;
EGOFOCUS_CANDIDATES(sse41)
EGOFOCUS_CANDIDATES(avx2)
EGOFOCUS_CANDIDATES(neon)
#undef EGOFOCUS_CANDIDATES

}  // namespace egofocus::bench
