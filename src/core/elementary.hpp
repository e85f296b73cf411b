// Elementary functions from + - * / and sqrt alone: IEEE 754 fixes their bits, so they are equal on every
// machine, which libm does not promise. Accuracy is far below what pixels or motion need (tests: 1e-13
// relative or absolute). Thread: any. RT: yes.
#pragma once

#include <cstdint>

namespace egofocus {

/// IEEE square root (an instruction, never a library call). Precondition: x >= 0.
inline double square_root(double x) noexcept {
  return __builtin_sqrt(x);
}
inline double absolute(double x) noexcept {
  return x < 0 ? -x : x;
}

/// Radians; |x| <= 1e5.
double sine(double x) noexcept;
double cosine(double x) noexcept;
double tangent(double x) noexcept;
double arc_tangent(double x) noexcept;
/// Four-quadrant; (0, 0) gives 0.
double arc_tangent2(double y, double x) noexcept;
/// e^x for |x| <= 700.
double exponential(double x) noexcept;

/// Largest integer <= x, for |x| < 2^53.
inline double floor_of(double x) noexcept {
  const double truncated = static_cast<double>(static_cast<std::int64_t>(x));
  return truncated > x ? truncated - 1.0 : truncated;
}

/// x without its fraction, for a Status: any double at all has an answer (NaN: 0; beyond +-10^18: that
/// bound).
constexpr std::int64_t status_value(double x) noexcept {
  constexpr double kLargest = 1e18;
  if (!(x > -kLargest)) return x <= -kLargest ? static_cast<std::int64_t>(-kLargest) : 0;
  return static_cast<std::int64_t>(x < kLargest ? x : kLargest);
}

}  // namespace egofocus
