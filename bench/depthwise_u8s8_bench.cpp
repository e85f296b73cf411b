// Multiply-adds per second of each variant on each layer, on one core: the median of runs, in processor time
// of the thread. Most of the work of a depthwise convolution is not multiplication: no share of a peak is
// claimed.
#include <benchmark/benchmark.h>

#include <random>
#include <string>

#include "depthwise_layers.hpp"
#include "kernels/kernel_table.hpp"
#include "take_turns.hpp"

namespace {

using namespace egofocus;
using namespace egofocus::bench;

void measure(benchmark::State& state, DepthwiseU8S8Function* run, DepthwisePacking packing,
             const DepthwiseLayer& layer) {
  const DepthwiseLoad load(layer, packing);
  std::mt19937 random(1);
  const int repeats = 1 + static_cast<int>(2e7 / load.multiplications());
  Rounds rounds(1);
  for (auto _ : state) {
    const double seconds = take_turns({{[&] { load.run(run); }, repeats}}, 1, random)[0][0];
    rounds[0].push_back(seconds);
    state.SetIterationTime(seconds);
  }
  const double median_s = medians_of(rounds, random)[0][0];
  state.counters["GMAC/s"] = 1e-9 * load.multiplications() / median_s;
  state.counters["us"] = 1e6 * median_s;
}

bool register_rows() {
  const auto add = [](const std::string& name, Isa isa, DepthwiseU8S8Function* run,
                      DepthwisePacking packing) {
    if (!has_isa(detect_isa(), isa)) return;
    for (const DepthwiseLayer& layer : kDepthwiseLayers) {
      const std::string full = "depthwise_u8s8_" + name + "/" + layer.name;
      benchmark::RegisterBenchmark(full.c_str(), measure, run, packing, layer)->UseManualTime();
    }
  };
#define EGOFOCUS_DEPTHWISE_U8S8(suffix, isa, block_channels, by_columns) \
  add(#suffix, Isa::isa, &depthwise_u8s8_##suffix, kDepthwisePacking_##suffix);
#include "kernels/depthwise_u8s8.inc"
#undef EGOFOCUS_DEPTHWISE_U8S8
  return true;
}

const bool kRegistered = register_rows();

}  // namespace
