// A wobble that never repeats: the road under a wheel, the tremor of a hand.
#pragma once

#include <array>

#include "citysim/random.hpp"

namespace egofocus::citysim {

/// A sum of sines whose frequencies are spread evenly over the logarithm of [low_hz, high_hz]. Its first
/// derivative has rms 1 and is equally strong in each octave; the value itself stays below bound().
class Shake {
 public:
  Shake(sim::Random& random, double low_hz, double high_hz) {
    const double step = sim::natural_log(high_hz / low_hz) / kSines;
    for (int i = 0; i < kSines; ++i) {
      Sine& sine = sines_[static_cast<std::size_t>(i)];
      sine.hz = low_hz * exponential((i + random.uniform()) * step);
      sine.turns = random.uniform();
      sine.amplitude = square_root(2.0 / kSines) / (kTwoPi * sine.hz);
    }
  }

  [[nodiscard]] double at(double t_s) const {
    double sum = 0;
    for (const Sine& s : sines_) {
      const double turns = s.hz * t_s + s.turns;
      sum += s.amplitude * sine(kTwoPi * (turns - floor_of(turns)));
    }
    return sum;
  }

  [[nodiscard]] double bound() const {
    double sum = 0;
    for (const Sine& s : sines_) sum += s.amplitude;
    return sum;
  }

 private:
  static constexpr int kSines = 14;
  static constexpr double kTwoPi = 6.28318530717958647692;
  struct Sine {
    double hz = 0;
    double turns = 0;  // phase
    double amplitude = 0;
  };
  std::array<Sine, kSines> sines_;
};

}  // namespace egofocus::citysim
