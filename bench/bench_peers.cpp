// bench_peers: each convolution of `base` at 346x260 as the library does it and as oneDNN does it, on one
// thread and within one tier of instruction sets, in turns; beside them what the core's multipliers can do.
// docs/kernels-conv.md says what is not like for like.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "conv_layers.hpp"
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
  const ConvLayer* layer;
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

Compared compare(const ConvLayer& layer, const Tier& tier, int rounds, std::mt19937& random) {
  const ChosenConvU8S8 kernel = select_kernels(isa_bit(tier.isa)).conv_u8s8;
  const ConvLoad load(layer, kernel.packing);
  OneDnnConv peer(layer, load);
  kernel.run(load.conv());
  if (!agree(load.outputs(), peer.outputs()))
    throw std::runtime_error(std::string(layer.name) + ": the two do not compute the same");
  const int repeats = 1 + static_cast<int>(1e8 / load.multiplications());
  constexpr std::int32_t kPeakRounds = 20000;
  const Rounds taken = take_turns({{[&] { kernel.run(load.conv()); }, repeats},
                                   {[&] { peer.run(); }, repeats},
                                   {[&] { tier.peak(kPeakRounds); }, 1}},
                                  rounds, random);
  return {&layer, load.multiplications(), static_cast<double>(tier.peak(kPeakRounds)), peer.implementation(),
          medians_of(taken, random)};
}

template <class Chosen>
Estimate geometric_mean(const std::vector<Compared>& all, Chosen&& chosen) {
  return estimate([&](std::size_t n) {
    double sum = 0;
    int count = 0;
    for (const Compared& c : all) {
      if (!chosen(*c.layer)) continue;
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
  for (const Compared& c : all) sum += c.layer->times * c.seconds(way, n);
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
    std::printf("%-24s %5d %8.1f %8.1f %5.1f%%  %.3f (%.3f .. %.3f)  %s\n", c.layer->name, c.layer->times,
                c.gmacs(kOurs), c.gmacs(kPeer), 100 * c.gmacs(kOurs) / c.peak_gmacs(), ratio.value, ratio.low,
                ratio.high, c.implementation.c_str());
  }
  for (const Total& total : totals)
    std::printf("%-55s  %.3f (%.3f .. %.3f)\n", total.name, total.ratio.value, total.ratio.low,
                total.ratio.high);
  std::printf("G multiply-adds a second; one tick: ours %.0f us, oneDNN %.0f us; peak: %.1f\n",
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
    out << (&c == all.data() ? "\n  " : ",\n  ") << "{\"name\": \"" << c.layer->name
        << "\", \"times\": " << c.layer->times << ", \"multiplications\": " << c.multiplications
        << ", \"ours_s\": " << c.seconds(kOurs, 0) << ", \"onednn_s\": " << c.seconds(kPeer, 0)
        << ", \"peak_gmacs\": " << c.peak_gmacs() << ", \"implementation\": \"" << c.implementation << "\", ";
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

int run(const Tier& tier, int rounds, const std::string& layer_name, const std::string& json) {
  if (!has_isa(detect_isa(), tier.isa))
    throw std::runtime_error(std::string(tier.name) + ": not on this machine");
  if (!limit_onednn(tier.isa))
    throw std::runtime_error(std::string("oneDNN does not take the tier ") + tier.name);
  std::printf("oneDNN %s, %s, one thread, %d rounds in turns\n", onednn_version().c_str(), tier.name, rounds);
  std::mt19937 random(1);
  std::vector<Compared> all;
  for (const ConvLayer& layer : kConvLayers) {
    if (std::string(layer.name).find(layer_name) != std::string::npos)
      all.push_back(compare(layer, tier, rounds, random));
  }
  if (all.empty()) throw std::runtime_error(layer_name + ": no layer has this in its name");
  std::vector<Total> totals;
  if (layer_name.empty()) {
    const double borders_s = border_seconds(random, rounds);
    std::printf("ours' borders, in the sum alone: %.1f us\n", 1e6 * borders_s);
    totals = {{"dense, geometric mean", geometric_mean(all, [](const ConvLayer& l) { return l.side == 3; })},
              {"1x1, geometric mean", geometric_mean(all, [](const ConvLayer& l) { return l.side == 1; })},
              {"all convolutions of a tick, sum", estimate([&](std::size_t n) {
                 return tick_seconds(all, kPeer, n) / (tick_seconds(all, kOurs, n) + borders_s);
               })}};
  }
  print(all, totals);
  if (!json.empty()) write_json(json, tier, rounds, all, totals);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"the network's convolutions beside oneDNN's, one thread, in turns"};
  std::string isa = kTiers[0].name, layer, json;
  int rounds = 200;
  std::vector<std::string> names;
  for (const Tier& tier : kTiers) names.push_back(tier.name);
  app.add_option("--isa", isa, "the tier that both keep to")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  app.add_option("--rounds", rounds, "of each layer")->check(CLI::Range(10, 100000))->capture_default_str();
  app.add_option("--layer", layer, "only layers with this in their names");
  app.add_option("--json", json, "also to this file");
  CLI11_PARSE(app, argc, argv);
  try {
    for (const Tier& tier : kTiers) {
      if (isa == tier.name) return run(tier, rounds, layer, json);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
  }
  return 1;
}
