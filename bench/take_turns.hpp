// Two or more ways to do a thing, timed in turns and in an order that changes, so that whatever slows the
// machine down meets all of them; medians, and how far chance may have moved them.
#pragma once

#include <cstddef>
#include <functional>
#include <random>
#include <vector>

namespace egofocus::bench {

/// [way][round]: seconds of one run, in processor time of the thread.
using Rounds = std::vector<std::vector<double>>;

struct Way {
  std::function<void()> run;
  int repeats = 1;  ///< per round: enough for the clock
};

/// The first round, which warms up, is left out.
Rounds take_turns(const std::vector<Way>& ways, int rounds, std::mt19937& random);

/// [way][n]: the median of all rounds first, then those of kResamples draws of as many rounds, the same
/// rounds for each way (bootstrap).
using Medians = std::vector<std::vector<double>>;
inline constexpr int kResamples = 1000;
Medians medians_of(const Rounds& rounds, std::mt19937& random);

/// A figure made of medians, with the middle 95 % of what the draws make of it.
struct Estimate {
  double value = 0;
  double low = 0;
  double high = 0;
};
/// figure(n): made of the n-th medians.
Estimate estimate(const std::function<double(std::size_t)>& figure);

}  // namespace egofocus::bench
