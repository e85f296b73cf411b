// Multiply-adds per second of each variant on each of the network's layers, and the time of all layers of one
// tick, on one core: the median of runs, in processor time of the thread. (Not the fastest one: a virtual
// machine's clock of a thread leaves out, now and then, more than the time that was stolen.) Of the scalar
// meaning only the whole is measured.
#include <benchmark/benchmark.h>

#include <time.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

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

/// Seconds of one run, from as many as the clock needs.
double time_of(const ConvLoad& load, ConvU8S8Function* run) {
  const int repeats = 1 + static_cast<int>(1e8 / load.multiplications());
  const double start = thread_seconds();
  for (int n = 0; n < repeats; ++n) load.run(run);
  return (thread_seconds() - start) / repeats;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void measure_layer(benchmark::State& state, ConvU8S8Function* run, ConvPacking packing,
                   const ConvLayer& layer) {
  const ConvLoad load(layer, packing);
  std::vector<double> times_s;
  for (auto _ : state) {
    times_s.push_back(time_of(load, run));
    state.SetIterationTime(times_s.back());
  }
  const double median_s = median(times_s);
  state.counters["GMAC/s"] = 1e-9 * load.multiplications() / median_s;
  state.counters["us"] = 1e6 * median_s;
}

void measure_all(benchmark::State& state, ConvU8S8Function* run, ConvPacking packing) {
  std::vector<std::unique_ptr<ConvLoad>> loads;
  double multiplications = 0;
  for (const ConvLayer& layer : kConvLayers) {
    loads.push_back(std::make_unique<ConvLoad>(layer, packing));
    multiplications += layer.times * loads.back()->multiplications();
  }
  std::vector<double> times_s;
  for (auto _ : state) {
    double taken = 0;
    for (std::size_t i = 0; i < loads.size(); ++i) {
      taken += kConvLayers[i].times * time_of(*loads[i], run);
    }
    times_s.push_back(taken);
    state.SetIterationTime(taken);
  }
  const double median_s = median(times_s);
  state.counters["GMAC"] = 1e-9 * multiplications;
  state.counters["GMAC/s"] = 1e-9 * multiplications / median_s;
  state.counters["us"] = 1e6 * median_s;
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
