#include "core/elementary.hpp"

#include <cstdint>

namespace egofocus {
namespace {

constexpr double kPi = 3.14159265358979323846;
// pi/2 in two parts: k * kHalfPiHigh is exact for |k| < 2^20.
constexpr double kHalfPiHigh = 0x1.921fb544p+0;
constexpr double kHalfPiLow = 0x1.0b4611a626331p-34;

// Taylor series on |x| <= pi/4: the remainder is below 1e-17.
double sine_core(double x) noexcept {
  const double s = x * x;
  double p = -1.0 / 1307674368000.0;
  p = p * s + 1.0 / 6227020800.0;
  p = p * s - 1.0 / 39916800.0;
  p = p * s + 1.0 / 362880.0;
  p = p * s - 1.0 / 5040.0;
  p = p * s + 1.0 / 120.0;
  p = p * s - 1.0 / 6.0;
  return x + x * s * p;
}

double cosine_core(double x) noexcept {
  const double s = x * x;
  double p = 1.0 / 20922789888000.0;
  p = p * s - 1.0 / 87178291200.0;
  p = p * s + 1.0 / 479001600.0;
  p = p * s - 1.0 / 3628800.0;
  p = p * s + 1.0 / 40320.0;
  p = p * s - 1.0 / 720.0;
  p = p * s + 1.0 / 24.0;
  p = p * s - 0.5;
  return 1.0 + s * p;
}

struct Reduced {
  double x;
  int quadrant;
};

Reduced reduce(double x) noexcept {
  const double k = floor_of(x * (2.0 / kPi) + 0.5);
  return {(x - k * kHalfPiHigh) - k * kHalfPiLow, static_cast<int>(static_cast<std::int64_t>(k) & 3)};
}

}  // namespace

double sine(double x) noexcept {
  const Reduced r = reduce(x);
  const double v = (r.quadrant & 1) ? cosine_core(r.x) : sine_core(r.x);
  return (r.quadrant & 2) ? -v : v;
}

double cosine(double x) noexcept {
  const Reduced r = reduce(x);
  const double v = (r.quadrant & 1) ? sine_core(r.x) : cosine_core(r.x);
  return (r.quadrant == 1 || r.quadrant == 2) ? -v : v;
}

double tangent(double x) noexcept {
  return sine(x) / cosine(x);
}

double arc_tangent(double x) noexcept {
  const bool negative = x < 0;
  double a = negative ? -x : x;
  const bool inverted = a > 1.0;
  if (inverted) a = 1.0 / a;
  // Halve the angle twice, atan(a) = 2 atan(a / (1 + sqrt(1 + a^2))): then a <= 0.199 and the series is
  // short.
  a = a / (1.0 + square_root(1.0 + a * a));
  a = a / (1.0 + square_root(1.0 + a * a));
  const double s = a * a;
  double p = 0;
  for (int n = 23; n >= 1; n -= 2) p = 1.0 / n - s * p;
  double v = 4.0 * a * p;
  if (inverted) v = 0.5 * kPi - v;
  return negative ? -v : v;
}

double arc_tangent2(double y, double x) noexcept {
  if (x > 0) return arc_tangent(y / x);
  if (x < 0) return arc_tangent(y / x) + (y < 0 ? -kPi : kPi);
  if (y > 0) return 0.5 * kPi;
  if (y < 0) return -0.5 * kPi;
  return 0;
}

double exponential(double x) noexcept {
  constexpr double kLog2 = 0.69314718055994530942;
  const double k = floor_of(x / kLog2 + 0.5);
  const double r = x - k * kLog2;  // |r| <= 0.35
  double term = 1.0;
  double sum = 1.0;
  for (int n = 1; n <= 16; ++n) {
    term = term * r / n;
    sum += term;
  }
  // Multiplying by 2 or 1/2 is exact.
  for (auto i = static_cast<std::int64_t>(k); i > 0; --i) sum *= 2.0;
  for (auto i = static_cast<std::int64_t>(k); i < 0; ++i) sum *= 0.5;
  return sum;
}

}  // namespace egofocus
