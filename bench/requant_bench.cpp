// Elements per second of each way to requantise. A candidate more than one step from the chosen rule is
// refused.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "kernels/isa.hpp"
#include "kernels/requant.hpp"
#include "requant_candidates.hpp"

namespace {

using namespace egofocus;
using namespace egofocus::bench;

constexpr std::size_t kElements = 2048;  // operands stay in the first cache

struct Operands {
  std::vector<std::int32_t> acc, multiplier, shift;
  std::vector<float> scale;
  std::vector<std::int16_t> multiplier16;
  std::vector<std::uint8_t> out;
};

Operands make_operands(bool wide) {
  constexpr std::int32_t kRightShift = 10;
  Operands o;
  std::mt19937 random(1);
  for (std::size_t i = 0; i < kElements; ++i) {
    const double scale = (200.0 + static_cast<double>(random() % 50)) / (1 << 19);
    o.acc.push_back(static_cast<std::int32_t>(random() % (1u << 20)) - (1 << 19));
    o.scale.push_back(static_cast<float>(scale));
    o.multiplier.push_back(
        static_cast<std::int32_t>(scale * static_cast<double>(std::int64_t{1} << (wide ? 39 : 41))));
    o.shift.push_back(-kRightShift);
    o.multiplier16.push_back(static_cast<std::int16_t>(scale * (1 << 26)));
  }
  o.out.resize(kElements);
  return o;
}

void measure(benchmark::State& state, RequantCandidate* run, bool wide) {
  Operands o = make_operands(wide);
  const RequantLoad load{o.acc.data(),   o.scale.data(),        o.multiplier.data(),
                         o.shift.data(), o.multiplier16.data(), o.out.data(),
                         kElements};
  for (auto _ : state) {
    run(load);
    benchmark::ClobberMemory();
  }
  for (std::size_t i = 0; i < kElements; ++i) {
    if (std::abs(o.out[i] - requant_u8(o.acc[i], o.scale[i], 0)) > 1) state.SkipWithError("wrong result");
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kElements));
}

bool register_candidates() {
  const auto add = [](const char* name, Isa isa, RequantCandidate* run) {
    if (!has_isa(detect_isa(), isa)) return;
    const std::string full = std::string("requant_") + name + "_" + isa_name(isa);
    benchmark::RegisterBenchmark(full.c_str(), measure, run, std::string(name) == "wide");
  };
#define EGOFOCUS_CANDIDATES(suffix, isa)             \
  add("wide", Isa::isa, &requant_wide_##suffix);     \
  add("double", Isa::isa, &requant_double_##suffix); \
  add("float", Isa::isa, &requant_float_##suffix);   \
  add("narrow", Isa::isa, &requant_narrow_##suffix);
#ifdef EGOFOCUS_HAVE_SSE41
  EGOFOCUS_CANDIDATES(sse41, kSse41)
#endif
#ifdef EGOFOCUS_HAVE_AVX2
  EGOFOCUS_CANDIDATES(avx2, kAvx2)
#endif
#ifdef EGOFOCUS_HAVE_NEON
  EGOFOCUS_CANDIDATES(neon, kNeon)
#endif
#undef EGOFOCUS_CANDIDATES
  return true;
}

const bool kRegistered = register_candidates();

}  // namespace
