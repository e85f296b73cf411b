// The network's input of one whole window on one core: base's maps, 346x260, 48 hypotheses.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <random>
#include <vector>

#include "pipeline/focus_input.hpp"

namespace {

using namespace egofocus;

void focus_input(benchmark::State& state) {
  const Intrinsics grid{346, 260, 226, 226, 173, 130};
  const auto hypotheses = static_cast<std::int32_t>(state.range(0));
  FocusInputConfig config;
  config.map_count = 5;
  const FocusMap maps[] = {{FocusMapKind::kGradient, 1},
                           {FocusMapKind::kGradient, 3},
                           {FocusMapKind::kGradient, 7},
                           {FocusMapKind::kSquares, 3},
                           {FocusMapKind::kSquares, 7}};
  std::copy(std::begin(maps), std::end(maps), config.maps);
  Arena counter;
  { const FocusInput counted(config, grid, hypotheses, 1, counter); }
  const std::unique_ptr<void, void (*)(void*)> block(
      std::aligned_alloc(Arena::kAlignment, counter.used_bytes()), std::free);
  Arena arena({static_cast<std::byte*>(block.get()), counter.used_bytes()});
  FocusInput input(config, grid, hypotheses, 1, arena);
  std::mt19937 random(1);
  std::vector<std::uint8_t> planes(static_cast<std::size_t>(hypotheses) * 346 * 260);
  for (auto& n : planes) n = random() % 8 == 0 ? static_cast<std::uint8_t>(random() % 6) : 0;
  HypothesisLadder ladder;
  ladder.count = hypotheses;
  ladder.step_per_m = 0.02;
  WorkerPool pool;
  for (auto _ : state) input.run(planes, ladder, {0.1, 0.2, 0.3}, pool);
  state.counters["arena_bytes"] = static_cast<double>(counter.used_bytes());
}
BENCHMARK(focus_input)->Arg(32)->Arg(48)->Unit(benchmark::kMillisecond);

}  // namespace
