// The inline forms of requant.hpp as functions over arrays, each compiled with the flags of its instruction
// set.
#pragma once

#include <cstdint>

namespace egofocus::test {

inline constexpr std::int32_t kRequantStep = 32;

struct RequantArrays {
  const std::int32_t* acc;
  const float* scale;
  std::int32_t n;  ///< a multiple of kRequantStep
  std::int32_t zero;
  std::int16_t* s16;
  std::uint8_t* u8;
  std::int8_t* s8;
};

using RequantFunction = void(const RequantArrays& arrays);

#define EGOFOCUS_REQUANT(suffix, isa) RequantFunction requant_rows_##suffix;
#include "requant_rows.inc"
#undef EGOFOCUS_REQUANT

}  // namespace egofocus::test
