// Natural logarithms from + - * / alone: the same bits on every machine, and a plain loop over them becomes
// vector code.
#pragma once

#include <bit>
#include <cstdint>

namespace egofocus::sim {

/// x positive and normal. Series of atanh on [sqrt(1/2), sqrt(2)): error below 1e-7 (float), 1e-14 (double).
inline float natural_log(float x) {
  const std::int32_t bits = std::bit_cast<std::int32_t>(x) - 0x3f3504f3;  // sqrt(1/2)
  const float exponent = static_cast<float>(bits >> 23);
  const float m = std::bit_cast<float>((bits & 0x007fffff) + 0x3f3504f3);
  const float s = (m - 1.0f) / (m + 1.0f);
  const float q = s * s;
  const float series = ((q * (1.0f / 9.0f) + 1.0f / 7.0f) * q + 1.0f / 5.0f) * q + 1.0f / 3.0f;
  return exponent * 0.693147181f + (2.0f * s + 2.0f * s * q * series);
}

inline double natural_log(double x) {
  const std::int64_t bits = std::bit_cast<std::int64_t>(x) - 0x3fe6a09e667f3bcd;  // sqrt(1/2)
  const double exponent = static_cast<double>(bits >> 52);
  const double m = std::bit_cast<double>((bits & 0x000fffffffffffff) + 0x3fe6a09e667f3bcd);
  const double s = (m - 1.0) / (m + 1.0);
  const double q = s * s;
  double series = 0;
  for (int n = 19; n >= 3; n -= 2) series = series * q + 1.0 / n;
  return exponent * 0.693147180559945309 + (2.0 * s + 2.0 * s * q * series);
}

}  // namespace egofocus::sim
