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

/// 0 <= k <= 700; error of both below 1e-14.
inline LowPassStep<double> low_pass_step(double k) {
  constexpr double kInverse[] = {1.0 / 2,  1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6,  1.0 / 7,  1.0 / 8, 1.0 / 9,
                                 1.0 / 10, 1.0 / 11, 1.0 / 12, 1.0 / 13, 1.0 / 14, 1.0 / 15, 1.0 / 16};
  const auto halvings = static_cast<std::int64_t>(k * 1.44269504088896341);
  const double r = k - static_cast<double>(halvings) * 0.693147180559945309;
  double lag = 1.0;  // sum of (-r)^n / (n + 1)!, from its last term inwards
  for (int n = 14; n >= 0; --n) lag = 1.0 - r * kInverse[n] * lag;
  const double decay = (1.0 - r * lag) * std::bit_cast<double>((1023 - halvings) << 52);
  return {decay, halvings == 0 ? lag : (1.0 - decay) / k};
}

}  // namespace egofocus::citysim
