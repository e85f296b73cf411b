#include "take_turns.hpp"

#include <time.h>

#include <algorithm>
#include <numeric>

namespace egofocus::bench {
namespace {

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Rounds take_turns(const std::vector<Way>& ways, int rounds, std::mt19937& random) {
  Rounds taken(ways.size());
  std::vector<std::size_t> order(ways.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (int round = 0; round <= rounds; ++round) {
    std::shuffle(order.begin(), order.end(), random);
    for (const std::size_t way : order) {
      const double start = thread_seconds();
      for (int n = 0; n < ways[way].repeats; ++n) ways[way].run();
      const double seconds = (thread_seconds() - start) / ways[way].repeats;
      if (round > 0) taken[way].push_back(seconds);
    }
  }
  return taken;
}

Medians medians_of(const Rounds& rounds, std::mt19937& random) {
  Medians medians;
  for (const std::vector<double>& times : rounds) medians.push_back({median(times)});
  const std::size_t count = rounds[0].size();
  std::vector<std::size_t> drawn(count);
  for (int n = 0; n < kResamples; ++n) {
    for (std::size_t& round : drawn) round = random() % count;
    for (std::size_t way = 0; way < rounds.size(); ++way) {
      std::vector<double> times(count);
      for (std::size_t i = 0; i < count; ++i) times[i] = rounds[way][drawn[i]];
      medians[way].push_back(median(std::move(times)));
    }
  }
  return medians;
}

Estimate estimate(const std::function<double(std::size_t)>& figure) {
  std::vector<double> draws;
  for (std::size_t n = 1; n <= kResamples; ++n) draws.push_back(figure(n));
  std::sort(draws.begin(), draws.end());
  return {figure(0), draws[kResamples / 40], draws[kResamples - 1 - kResamples / 40]};
}

}  // namespace egofocus::bench
