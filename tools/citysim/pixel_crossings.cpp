#include "citysim/pixel_crossings.hpp"

#include "citysim/logarithm.hpp"
#include "citysim/low_pass.hpp"
#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kTolerance_us = 0.05;

/// The filtered level at the part `u` of the step, 0 to 1.
double level_at(const LevelStep& s, double u) {
  const LowPassStep<double> part = low_pass_step(s.k * u);
  const double rise = (s.log1 - s.log0) * u;
  return s.log0 + rise + (s.level0 - s.log0) * part.decay - rise * part.lag;
}

/// A part of the step in which the level only rises or only falls.
struct Piece {
  double begin;
  double end;
  double begin_level;
  double end_level;
};

/// Where the piece meets `target`, as a part of the step. Newton's steps from the chord, halving where they
/// leave the bracket. The slope is exact: d level / du = k (log - level).
double meet(const LevelStep& s, const Piece& piece, double target) {
  const bool rising = piece.end_level > piece.begin_level;
  const double tolerance = kTolerance_us / s.span_us;
  const double log_slope = s.log1 - s.log0;
  double low = piece.begin;
  double high = piece.end;
  double u = low + (high - low) * ((target - piece.begin_level) / (piece.end_level - piece.begin_level));
  for (int i = 0; i < 60; ++i) {
    const double level = level_at(s, u);
    if ((level >= target) == rising) {
      high = u;
    } else {
      low = u;
    }
    const double slope = s.k * (s.log0 + log_slope * u - level);
    double next = u + (target - level) / slope;
    // What a Newton step leaves is its square times curvature / (2 slope).
    double left = absolute((next - u) * (next - u) * s.k * (log_slope - slope) / (2.0 * slope));
    if (!(next > low && next < high)) {
      next = 0.5 * (low + high);
      left = high - low;
    }
    u = next;
    if (left < tolerance) break;
  }
  return u;
}

/// All crossings on the way to `level`; `when(threshold)` tells the time.
template <typename When>
void follow(double level, Comparators& c, const When& when, std::vector<Crossing>& crossings) {
  while (level >= c.upper) {
    crossings.push_back({when(c.upper), true});
    c.lower = c.upper - c.off;
    c.upper += c.on;
  }
  while (level <= c.lower) {
    crossings.push_back({when(c.lower), false});
    c.upper = c.lower + c.on;
    c.lower -= c.off;
  }
}

void follow(const LevelStep& s, const Piece& piece, Comparators& c, std::vector<Crossing>& crossings) {
  follow(
      piece.end_level, c, [&](double target) { return s.span_us * meet(s, piece, target); }, crossings);
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
    const auto straight = [&](double target) { return s.span_us * ((target - s.log0) / (s.log1 - s.log0)); };
    follow(s.log1, comparators, straight, crossings);
    return;
  }
  const double turn = turning_part(s);
  Piece piece{0, 1, s.level0, s.level1};
  if (turn > 0) {
    piece.end = turn;
    piece.end_level = level_at(s, turn);
    follow(s, piece, comparators, crossings);
    piece = {turn, 1, piece.end_level, s.level1};
  }
  follow(s, piece, comparators, crossings);
}

}  // namespace egofocus::citysim
