#include "citysim/pixel_crossings.hpp"

#include "citysim/logarithm.hpp"
#include "citysim/low_pass.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kTolerance_us = 0.05;

/// The filtered level at the part `u` of the step, 0 to 1.
double level_at(const LevelStep& s, double u) {
  const LowPassStep<double> part = low_pass_step(s.k * u);
  const double rise = (s.log1 - s.log0) * u;
  return s.log0 + rise + (s.level0 - s.log0) * part.decay - rise * part.lag;
}

/// Where a piece [begin, end] of the step, on which the level only rises or only falls, meets `target`.
/// Newton's steps, halving where they leave the bracket. The slope is exact: d level / du = k (log - level).
double meet(const LevelStep& s, double target, double begin, double end, bool rising) {
  const double tolerance = kTolerance_us / s.span_us;
  double low = begin;
  double high = end;
  double u = 0.5 * (low + high);
  for (int i = 0; i < 60; ++i) {
    const double level = level_at(s, u);
    if ((level >= target) == rising) {
      high = u;
    } else {
      low = u;
    }
    const double slope = s.k * (s.log0 + (s.log1 - s.log0) * u - level);
    double next = u + (target - level) / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double moved = next > u ? next - u : u - next;
    u = next;
    if (moved < tolerance) break;
  }
  return u;
}

/// A piece that ends at `level`; `when(threshold, rising)` tells the time.
template <typename When>
void follow(double level, Comparators& c, const When& when, std::vector<Crossing>& crossings) {
  while (level >= c.upper) {
    crossings.push_back({when(c.upper, true), true});
    c.lower = c.upper - c.off;
    c.upper += c.on;
  }
  while (level <= c.lower) {
    crossings.push_back({when(c.lower, false), false});
    c.upper = c.lower + c.on;
    c.lower -= c.off;
  }
}

/// The part of the step at which the level turns, that is meets the log light; 0 when it does not.
double turning_part(const LevelStep& s) {
  const double rise = s.log1 - s.log0;
  const double ratio = 1.0 + (s.level0 - s.log0) * s.k / rise;
  if (!(ratio > 1.0 && ratio < 1e30)) return 0;
  const double u = sim::natural_log(ratio) / s.k;
  return u < 1.0 ? u : 0;
}

}  // namespace

void find_crossings(const LevelStep& s, Comparators& comparators, std::vector<Crossing>& crossings) {
  if (s.k < 0) {
    const auto straight = [&](Level target, bool) {
      return s.span_us * ((target - s.log0) / (s.log1 - s.log0));
    };
    follow(s.log1, comparators, straight, crossings);
    return;
  }
  const double turn = turning_part(s);
  const auto before_turn = [&](Level target, bool rising) {
    return s.span_us * meet(s, target, 0, turn, rising);
  };
  const auto after_turn = [&](Level target, bool rising) {
    return s.span_us * meet(s, target, turn, 1, rising);
  };
  if (turn > 0) follow(level_at(s, turn), comparators, before_turn, crossings);
  follow(s.level1, comparators, after_turn, crossings);
}

}  // namespace egofocus::citysim
