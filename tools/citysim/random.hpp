// Random numbers that are the same everywhere: integer arithmetic, and doubles made by exact operations.
#pragma once

#include <cstdint>
#include <string_view>

#include "citysim/logarithm.hpp"
#include "core/elementary.hpp"

namespace egofocus::sim {

/// One step of a well-mixing 64-bit hash (multiply and xor-shift, constants of SplitMix64).
inline std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(mix_bits(seed)) {}
  /// A stream of its own for each use of a seed.
  Random(std::uint64_t seed, std::string_view use) : state_(mix_bits(seed)) {
    for (const char letter : use) state_ = mix_bits(state_ ^ static_cast<unsigned char>(letter));
  }

  std::uint64_t bits() { return mix_bits(state_++); }
  /// [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in the logarithm; 0 < low < high.
  double log_uniform(double low, double high) {
    return exponential(uniform(natural_log(low), natural_log(high)));
  }
  bool chance(double probability) { return uniform() < probability; }
  /// [0, n)
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(((bits() >> 32) * n) >> 32); }
  /// Mean 0, deviation 1: the sum of twelve uniforms, so never beyond 6.
  double normal() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }
  /// The same of uniforms of 16 bits, four from one number: for what is drawn by the million.
  double coarse_normal() {
    std::uint64_t sum = 0;
    for (int i = 0; i < 3; ++i) {
      const std::uint64_t four = bits();
      sum += (four & 0xffff) + (four >> 16 & 0xffff) + (four >> 32 & 0xffff) + (four >> 48);
    }
    return (static_cast<double>(sum) + 6.0) * 0x1p-16 - 6.0;  // each uniform at the middle of its step
  }

 private:
  std::uint64_t state_;
};

}  // namespace egofocus::sim
