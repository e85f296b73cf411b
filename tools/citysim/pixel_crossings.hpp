// One pixel's step between two views in full: when its level crosses which threshold.
#pragma once

#include <vector>

#include "citysim/pixel_levels.hpp"

namespace egofocus::citysim {

/// A pixel's comparators. The reference level is upper - on = lower + off; every crossing moves all by one
/// threshold, in integers: exactly.
struct Comparators {
  Level upper;
  Level lower;
  Level on;  ///< thresholds, above 0
  Level off;
};

/// Log light runs straight from log0 to log1; the filtered level starts at level0 and ends at level1. `k` is
/// the step's length in time constants of the low pass; below 0: no filter, levels are the log light.
struct LevelStep {
  double log0;
  double log1;
  double level0;
  double level1;
  double k;
  double span_us;
};

struct Crossing {
  double after_us;  ///< since the step's start, 0 to span_us; found within 0.1 us
  bool on;
};

/// Appends the crossings in order of time and moves the comparators. Precondition: level0 is between them.
void find_crossings(const LevelStep& step, Comparators& comparators, std::vector<Crossing>& crossings);

}  // namespace egofocus::citysim
