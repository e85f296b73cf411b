// bench_peers: each convolution of `base` at 346x260, or depthwise ones, or those over planes, as the library
// does it and as oneDNN does it, on one thread and within one tier of instruction sets, in turns; beside them
// what the core's multipliers can do. docs/kernels-conv.md says what is not like for like.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "conv_layers.hpp"
#include "depthwise_layers.hpp"
#include "kernels/kernel_table.hpp"
#include "mac_peak.hpp"
#include "onednn_conv.hpp"
#include "pipeline/tensor.hpp"
#include "take_turns.hpp"

namespace {

using namespace egofocus;
using namespace egofocus::bench;

struct Tier {
  const char* name;
  Isa isa;
  MacPeakFunction* peak;
};

constexpr Tier kTiers[] = {
    {"avx512vnni", Isa::kAvx512Vnni, &mac_peak_avx512vnni},
    {"avxvnni", Isa::kAvxVnni, &mac_peak_avxvnni},
    {"avx2", Isa::kAvx2, &mac_peak_avx2},
    {"sse41", Isa::kSse41, &mac_peak_sse41},
};

enum WayIndex : std::size_t { kOurs, kPeer, kPeak };

struct Compared {
  std::string name;
  int times;    // in a tick
  bool window;  // no 1x1
  double multiplications;
  double peak_multiplications;
  std::string implementation;
  Medians medians;  // by WayIndex

  double seconds(WayIndex way, std::size_t n) const { return medians[way][n]; }
  double gmacs(WayIndex way) const { return 1e-9 * multiplications / seconds(way, 0); }
  double peak_gmacs() const { return 1e-9 * peak_multiplications / seconds(kPeak, 0); }
  Estimate ratio() const {
    return estimate([this](std::size_t n) { return seconds(kPeer, n) / seconds(kOurs, n); });
  }
};

/// Sums may leave one step apart where the addend of kAdd takes part in their rounding.
bool agree(const std::vector<std::int32_t>& ours, const std::vector<std::int32_t>& theirs) {
  std::size_t differing = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    if (std::abs(ours[i] - theirs[i]) > 1) return false;
    differing += ours[i] != theirs[i];
  }
  return ours.size() == theirs.size() && 1000 * differing <= ours.size();
}

struct Run {
  const Tier& tier;
  int rounds;
  std::string layer;  // what is in the names of the layers wanted
  std::mt19937 random{1};
};

int times_in_a_tick(const ConvLayer& layer) {
  return layer.times;
}
int times_in_a_tick(const DepthwiseLayer&) {
  return 1;
}
bool has_window(const ConvLayer& layer) {
  return layer.side * layer.depth > 1;
}
bool has_window(const DepthwiseLayer&) {
  return true;
}

template <class Load, class Layer, class Chosen>
Compared compare(const Layer& layer, const Chosen& kernel, Run& run) {
  const Load load(layer, kernel.packing);
  OneDnnConv peer(problem_of(load));
  load.run(kernel.run);
  if (!agree(load.outputs(), peer.outputs()))
    throw std::runtime_error(std::string(layer.name) + ": the two do not compute the same");
  const int repeats = 1 + static_cast<int>(1e8 / load.multiplications());
  constexpr std::int32_t kPeakRounds = 20000;
  const Rounds taken = take_turns({{[&] { load.run(kernel.run); }, repeats},
                                   {[&] { peer.run(); }, repeats},
                                   {[&] { run.tier.peak(kPeakRounds); }, 1}},
                                  run.rounds, run.random);
  return {layer.name,
          times_in_a_tick(layer),
          has_window(layer),
          load.multiplications(),
          static_cast<double>(run.tier.peak(kPeakRounds)),
          peer.implementation(),
          medians_of(taken, run.random)};
}

template <class Load, class Layers, class Chosen>
std::vector<Compared> compare_all(const Layers& layers, const Chosen& kernel, Run& run) {
  std::vector<Compared> all;
  for (const auto& layer : layers) {
    if (std::string(layer.name).find(run.layer) != std::string::npos)
      all.push_back(compare<Load>(layer, kernel, run));
  }
  if (all.empty()) throw std::runtime_error(run.layer + ": no layer has this in its name");
  return all;
}

template <class Chosen>
Estimate geometric_mean(const std::vector<Compared>& all, Chosen&& chosen) {
  return estimate([&](std::size_t n) {
    double sum = 0;
    int count = 0;
    for (const Compared& c : all) {
      if (!chosen(c)) continue;
      sum += std::log(c.seconds(kPeer, n) / c.seconds(kOurs, n));
      ++count;
    }
    return std::exp(sum / count);
  });
}

/// What ours needs beside its convolutions: borders of zeros around their inputs, each tensor once.
double border_seconds(std::mt19937& random, int rounds) {
  struct Filled {
    TensorShape shape;
    std::vector<std::uint8_t> bytes;
  };
  std::vector<Filled> all;
  const TensorShape at_4{87, 65, 48, 1}, at_8{44, 33, 80, 1}, at_16{22, 17, 128, 1}, refine{173, 130, 16, 4};
  for (const TensorShape& shape :
       {TensorShape{87, 65, 8, 1}, TensorShape{87, 65, 8, 1}, at_4, at_4, at_4, at_8, at_8, at_8, at_16,
        at_16, TensorShape{173, 130, 8, 1}, refine, refine})
    all.push_back({shape, std::vector<std::uint8_t>(shape.bytes())});
  const auto fill = [&all] {
    for (Filled& f : all) {
      const std::int32_t first = f.shape.border * (f.shape.row_stride() + f.shape.channels);
      Tensor(f.shape, f.bytes.data() + first).fill_border(0);
    }
  };
  return medians_of(take_turns({{fill, 10}}, rounds, random), random)[0][0];
}

double tick_seconds(const std::vector<Compared>& all, WayIndex way, std::size_t n) {
  double sum = 0;
  for (const Compared& c : all) sum += c.times * c.seconds(way, n);
  return sum;
}

struct Total {
  const char* name;
  Estimate ratio;
};

void print(const std::vector<Compared>& all, const std::vector<Total>& totals) {
  std::printf("%-24s %5s %8s %8s %6s  %-22s %s\n", "layer", "times", "ours", "oneDNN", "peak",
              "ours/oneDNN (95 %)", "oneDNN's implementation");
  for (const Compared& c : all) {
    const Estimate ratio = c.ratio();
    std::printf("%-24s %5d %8.1f %8.1f %5.1f%%  %.3f (%.3f .. %.3f)  %s\n", c.name.c_str(), c.times,
                c.gmacs(kOurs), c.gmacs(kPeer), 100 * c.gmacs(kOurs) / c.peak_gmacs(), ratio.value, ratio.low,
                ratio.high, c.implementation.c_str());
  }
  for (const Total& total : totals)
    std::printf("%-55s  %.3f (%.3f .. %.3f)\n", total.name, total.ratio.value, total.ratio.low,
                total.ratio.high);
  std::printf("G multiply-adds a second; all: ours %.0f us, oneDNN %.0f us; peak: %.1f\n",
              1e6 * tick_seconds(all, kOurs, 0), 1e6 * tick_seconds(all, kPeer, 0), all[0].peak_gmacs());
}

void write_json(const std::string& path, const Tier& tier, int rounds, const std::vector<Compared>& all,
                const std::vector<Total>& totals) {
  std::ofstream out(path);
  const auto put = [&out](const char* name, const Estimate& e) {
    out << '"' << name << "\": [" << e.value << ", " << e.low << ", " << e.high << ']';
  };
  out << "{\"isa\": \"" << tier.name << "\", \"onednn\": \"" << onednn_version()
      << "\", \"rounds\": " << rounds << ",\n \"layers\": [";
  for (const Compared& c : all) {
    out << (&c == all.data() ? "\n  " : ",\n  ") << "{\"name\": \"" << c.name << "\", \"times\": " << c.times
        << ", \"multiplications\": " << c.multiplications << ", \"ours_s\": " << c.seconds(kOurs, 0)
        << ", \"onednn_s\": " << c.seconds(kPeer, 0) << ", \"peak_gmacs\": " << c.peak_gmacs()
        << ", \"implementation\": \"" << c.implementation << "\", ";
    put("ratio", c.ratio());
    out << '}';
  }
  out << "],\n \"totals\": {";
  for (const Total& total : totals) {
    out << (&total == totals.data() ? "" : ", ");
    put(total.name, total.ratio);
  }
  out << "}}\n";
  if (!out.flush()) throw std::runtime_error(path + ": cannot be written");
}

void run(const std::string& operators, const std::string& json, Run& run) {
  const Tier& tier = run.tier;
  if (!has_isa(detect_isa(), tier.isa))
    throw std::runtime_error(std::string(tier.name) + ": not on this machine");
  if (!limit_onednn(tier.isa))
    throw std::runtime_error(std::string("oneDNN does not take the tier ") + tier.name);
  std::printf("oneDNN %s, %s, one thread, %d rounds in turns\n", onednn_version().c_str(), tier.name,
              run.rounds);
  const KernelTable kernels = select_kernels(isa_bit(tier.isa));
  std::vector<Compared> all;
  std::vector<Total> totals;
  if (operators == "network") {
    all = compare_all<ConvLoad>(kConvLayers, kernels.conv_u8s8, run);
    if (run.layer.empty()) {
      const double borders_s = border_seconds(run.random, run.rounds);
      std::printf("ours' borders, in the sum alone: %.1f us\n", 1e6 * borders_s);
      totals = {{"dense, geometric mean", geometric_mean(all, [](const Compared& c) { return c.window; })},
                {"1x1, geometric mean", geometric_mean(all, [](const Compared& c) { return !c.window; })},
                {"all convolutions of a tick, sum", estimate([&](std::size_t n) {
                   return tick_seconds(all, kPeer, n) / (tick_seconds(all, kOurs, n) + borders_s);
                 })}};
    }
  } else {
    all = operators == "planes" ? compare_all<ConvLoad>(kPlaneLayers, kernels.conv_u8s8, run)
                                : compare_all<DepthwiseLoad>(kDepthwiseLayers, kernels.depthwise_u8s8, run);
    totals = {{"geometric mean", geometric_mean(all, [](const Compared&) { return true; })}};
  }
  print(all, totals);
  if (!json.empty()) write_json(json, tier, run.rounds, all, totals);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"convolutions beside oneDNN's, one thread, in turns"};
  std::string isa = kTiers[0].name, operators = "network", layer, json;
  int rounds = 200;
  std::vector<std::string> names;
  for (const Tier& tier : kTiers) names.push_back(tier.name);
  app.add_option("--isa", isa, "the tier that both keep to")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  app.add_option("--operators", operators, "those of the network, depthwise ones, or those over planes")
      ->check(CLI::IsMember({"network", "depthwise", "planes"}))
      ->capture_default_str();
  app.add_option("--rounds", rounds, "of each layer")->check(CLI::Range(10, 100000))->capture_default_str();
  app.add_option("--layer", layer, "only layers with this in their names");
  app.add_option("--json", json, "also to this file");
  CLI11_PARSE(app, argc, argv);
  try {
    for (const Tier& tier : kTiers) {
      if (isa != tier.name) continue;
      Run chosen{tier, rounds, layer};
      run(operators, json, chosen);
      return 0;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
  }
  return 1;
}
