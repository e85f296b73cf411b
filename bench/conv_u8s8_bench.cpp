// Multiply-adds per second of each variant on each of the network's layers, and the time of all layers of one
// tick, on one core. The fastest run in processor time of the thread counts: neighbours only ever slow a run
// down. Of the scalar meaning only the whole is measured.
#include <benchmark/benchmark.h>

#include <time.h>

#include <algorithm>
#include <memory>
#include <string>

#include "conv_layers.hpp"
#include "kernels/kernel_table.hpp"

namespace {

using namespace egofocus;
using namespace egofocus::bench;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double time_of(const ConvU8S8& conv, ConvU8S8Function* run) {
  const double start = thread_seconds();
  run(conv);
  return thread_seconds() - start;
}

void measure_layer(benchmark::State& state, ConvU8S8Function* run, ConvPacking packing,
                   const ConvLayer& layer) {
  const ConvLoad load(layer, packing);
  double best_s = 1e9;
  for (auto _ : state) {
    const double taken = time_of(load.conv(), run);
    best_s = std::min(best_s, taken);
    state.SetIterationTime(taken);
  }
  state.counters["GMAC/s"] = 1e-9 * load.multiplications() / best_s;
  state.counters["us"] = 1e6 * best_s;
}

void measure_all(benchmark::State& state, ConvU8S8Function* run, ConvPacking packing) {
  std::vector<std::unique_ptr<ConvLoad>> loads;
  double multiplications = 0;
  for (const ConvLayer& layer : kConvLayers) {
    loads.push_back(std::make_unique<ConvLoad>(layer, packing));
    multiplications += layer.times * loads.back()->multiplications();
  }
  double best_s = 1e9;
  for (auto _ : state) {
    double taken = 0;
    for (std::size_t i = 0; i < loads.size(); ++i) {
      for (std::int32_t n = 0; n < kConvLayers[i].times; ++n) taken += time_of(loads[i]->conv(), run);
    }
    best_s = std::min(best_s, taken);
    state.SetIterationTime(taken);
  }
  state.counters["GMAC"] = 1e-9 * multiplications;
  state.counters["GMAC/s"] = 1e-9 * multiplications / best_s;
  state.counters["us"] = 1e6 * best_s;
}

bool register_rows() {
  const auto add = [](const std::string& name, Isa isa, ConvU8S8Function* run, ConvPacking packing) {
    if (!has_isa(detect_isa(), isa)) return;
    const std::string all = "conv_u8s8_" + name + "/all_of_a_tick";
    benchmark::RegisterBenchmark(all.c_str(), measure_all, run, packing)->UseManualTime();
    if (isa == Isa::kScalar) return;
    for (const ConvLayer& layer : kConvLayers) {
      const std::string full = "conv_u8s8_" + name + "/" + layer.name;
      benchmark::RegisterBenchmark(full.c_str(), measure_layer, run, packing, layer)->UseManualTime();
    }
  };
#define EGOFOCUS_CONV_U8S8(suffix, isa, tile_outputs, group_inputs) \
  add(#suffix, Isa::isa, &conv_u8s8_##suffix, kConvPacking_##suffix);
#include "kernels/conv_u8s8.inc"
#undef EGOFOCUS_CONV_U8S8
  return true;
}

const bool kRegistered = register_rows();

}  // namespace
