// A first-order low pass (time constant tau) over a time dt = k tau in which its input runs straight from
// x0 to x1. The exact solution is
//
//   y1 = x1 + (y0 - x0) decay - (x1 - x0) lag,    decay = e^-k,  lag = (1 - e^-k) / k
//
// From + - * / alone, without cancellation at small k: the same bits on every machine.
#pragma once

#include <bit>
#include <cstdint>

namespace egofocus::citysim {

template <typename Real>
struct LowPassStep {
  Real decay;
  Real lag;
};

/// 0 <= k <= 80; error of both below 3e-7. A plain loop over it becomes vector code.
inline LowPassStep<float> low_pass_step(float k) {
  const auto halvings = static_cast<std::int32_t>(k * 1.44269504f);
  const float r = k - static_cast<float>(halvings) * 0.693147181f;  // 0 to log 2
  float lag = 1.0f / 5040.0f - r * (1.0f / 40320.0f);
  lag = 1.0f / 720.0f - r * lag;
  lag = 1.0f / 120.0f - r * lag;
  lag = 1.0f / 24.0f - r * lag;
  lag = 1.0f / 6.0f - r * lag;
  lag = 0.5f - r * lag;
  lag = 1.0f - r * lag;
  const float decay = (1.0f - r * lag) * std::bit_cast<float>((127 - halvings) << 23);
  return {decay, halvings == 0 ? lag : (1.0f - decay) / k};
}

/// 0 <= k <= 700; error of both below 1e-11.
inline LowPassStep<double> low_pass_step(double k) {
  const auto halvings = static_cast<std::int64_t>(k * 1.44269504088896341);
  const double r = k - static_cast<double>(halvings) * 0.693147180559945309;
  const double r2 = r * r;
  const double r4 = r2 * r2;
  // The sum of (-r)^n / (n + 1)! to n = 11, in pairs, which do not wait for each other.
  const double a = (1.0 - r * (1.0 / 2)) + (1.0 / 6 - r * (1.0 / 24)) * r2;
  const double b = (1.0 / 120 - r * (1.0 / 720)) + (1.0 / 5040 - r * (1.0 / 40320)) * r2;
  const double c = (1.0 / 362880 - r * (1.0 / 3628800)) + (1.0 / 39916800 - r * (1.0 / 479001600)) * r2;
  const double lag = a + (b + c * r4) * r4;
  const double decay = (1.0 - r * lag) * std::bit_cast<double>((1023 - halvings) << 52);
  return {decay, halvings == 0 ? lag : (1.0 - decay) / k};
}

}  // namespace egofocus::citysim
