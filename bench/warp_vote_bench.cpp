// Votes per second of each variant, on one core. Kernel and bounds take turns, so that a change of the clock
// meets all of them, and each counts its fastest run in processor time of the thread: neighbours only ever
// slow a run down. share_of_votes and share_of_runs are time of bound / time of kernel (see VoteBound).
#include <benchmark/benchmark.h>

#include <time.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "kernels/kernel_table.hpp"
#include "vote_load.hpp"

namespace {

using namespace egofocus;
using namespace egofocus::bench;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Runs it; keeps the fastest time so far in best_s and returns this run's.
template <class Action>
double time_of(double& best_s, Action&& action) {
  const double start = thread_seconds();
  action();
  const double taken = thread_seconds() - start;
  best_s = best_s == 0.0 ? taken : std::min(best_s, taken);
  return taken;
}

void measure(benchmark::State& state, WarpVoteFunction* run, EventPattern pattern) {
  VoteLoad load(pattern);
  const WarpVote vote = load.vote();
  const VoteBound bound(vote);
  const std::size_t scratch_bytes =
      sizeof(std::uint32_t) * static_cast<std::size_t>(vote.width * vote.height);
  std::int64_t landed = 0;
  double kernel_s = 0;
  double votes_s = 0;
  double runs_s = 0;
  for (auto _ : state) {
    state.SetIterationTime(time_of(kernel_s, [&] { landed = run(vote); }));
    time_of(votes_s, [&] { bound.run_votes(vote); });
    time_of(runs_s, [&] { bound.run_runs(vote); });
    std::memset(vote.scratch, 0, scratch_bytes);
  }
  state.counters["votes/s"] = static_cast<double>(landed) / kernel_s;
  state.counters["share_of_votes"] = votes_s / kernel_s;
  state.counters["share_of_runs"] = runs_s / kernel_s;
}

bool register_rows() {
  const auto add = [](const char* name, Isa isa, WarpVoteFunction* run) {
    if (!has_isa(detect_isa(), isa)) return;
    for (EventPattern pattern : {EventPattern::kEdges, EventPattern::kUniform}) {
      const std::string full =
          std::string("warp_vote_u8_") + name + (pattern == EventPattern::kEdges ? "/edges" : "/uniform");
      benchmark::RegisterBenchmark(full.c_str(), measure, run, pattern)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  };
#define EGOFOCUS_WARP_VOTE(suffix, isa) add(#suffix, Isa::isa, &warp_vote_u8_##suffix);
#include "kernels/warp_vote.inc"
#undef EGOFOCUS_WARP_VOTE
  return true;
}

const bool kRegistered = register_rows();

}  // namespace
