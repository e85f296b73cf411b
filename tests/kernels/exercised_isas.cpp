#include "exercised_isas.hpp"

#define CATCH_CONFIG_EXTERNAL_INTERFACES  // the listener classes
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace egofocus::test {
namespace {

std::map<std::string, IsaSet>& exercised() {
  static std::map<std::string, IsaSet> by_op;
  return by_op;
}

/// Where an op has no body for a level, the one below runs: what is listed here must not go missing.
IsaSet bodies_of(const std::string& op) {
  const auto set_of = [](std::initializer_list<Isa> isas) {
    IsaSet set = isa_bit(Isa::kScalar);
    for (Isa isa : isas) set |= isa_bit(isa);
    return set;
  };
  if (op == "conv_u8s8") {
    return set_of(
        {Isa::kSse41, Isa::kAvx2, Isa::kAvxVnni, Isa::kAvx512Vnni, Isa::kNeon, Isa::kNeonDot, Isa::kNeonMm});
  }
  if (op == "depthwise_u8s8")
    return set_of({Isa::kSse41, Isa::kAvx2, Isa::kAvxVnni, Isa::kAvx512Vnni, Isa::kNeon, Isa::kNeonDot});
  return set_of({Isa::kSse41, Isa::kAvx2, Isa::kAvx512, Isa::kNeon});
}

IsaSet compiled_isas() {
  IsaSet set = isa_bit(Isa::kScalar);
#ifdef EGOFOCUS_HAVE_SSE41
  set |= isa_bit(Isa::kSse41);
#endif
#ifdef EGOFOCUS_HAVE_AVX2
  set |= isa_bit(Isa::kAvx2);
#endif
#ifdef EGOFOCUS_HAVE_AVX512
  set |= isa_bit(Isa::kAvx512);
#endif
#ifdef EGOFOCUS_HAVE_NEON
  set |= isa_bit(Isa::kNeon);
#endif
#ifdef EGOFOCUS_HAVE_AVXVNNI
  set |= isa_bit(Isa::kAvxVnni);
#endif
#ifdef EGOFOCUS_HAVE_AVX512VNNI
  set |= isa_bit(Isa::kAvx512Vnni);
#endif
#ifdef EGOFOCUS_HAVE_NEONDOT
  set |= isa_bit(Isa::kNeonDot);
#endif
#ifdef EGOFOCUS_HAVE_NEONMM
  set |= isa_bit(Isa::kNeonMm);
#endif
  return set;
}

IsaSet expected_isas() {
  const char* forced = std::getenv("EGOFOCUS_EXPECT_ISA");
  if (forced == nullptr) return compiled_isas() & detect_isa();
  const std::string list = std::string(",").append(forced).append(",");
  IsaSet set = isa_bit(Isa::kScalar);
  for (Isa isa : kEveryIsa) {
    if (list.find(std::string(",").append(isa_name(isa)).append(",")) != std::string::npos)
      set |= isa_bit(isa);
  }
  return set;
}

std::string names(IsaSet set) {
  std::string text;
  for (Isa isa : kEveryIsa) {
    if (has_isa(set, isa)) text.append(" ").append(isa_name(isa));
  }
  return text;
}

struct IsaReport : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;

  void testRunEnded(const Catch::TestRunStats& stats) override {
    // A failed assertion ends its loop over the rows early: what is missing then says nothing.
    const bool complete = stats.totals.testCases.allOk();
    const IsaSet expected = expected_isas();
    bool missing = false;
    std::printf("seed %u; compiled:%s; not exercised here:%s\n", test_seed(), names(compiled_isas()).c_str(),
                names(compiled_isas() & ~detect_isa()).c_str());
    for (const auto& [op, set] : exercised()) {
      std::printf("%s: exercised:%s\n", op.c_str(), names(set).c_str());
      const IsaSet left_out = expected & bodies_of(op) & ~set;
      if (!complete || left_out == 0) continue;
      std::printf("%s: FAILED, expected but not exercised:%s\n", op.c_str(), names(left_out).c_str());
      missing = true;
    }
    std::fflush(stdout);
    if (missing) std::_Exit(EXIT_FAILURE);
  }
};

CATCH_REGISTER_LISTENER(IsaReport)

}  // namespace

bool exercise(const char* op, Isa isa) {
  IsaSet& set = exercised()[op];
  if (!has_isa(detect_isa(), isa)) return false;
  set |= isa_bit(isa);
  return true;
}

std::uint32_t test_seed() {
  const char* chosen = std::getenv("EGOFOCUS_TEST_SEED");
  return chosen == nullptr ? 20240229u : static_cast<std::uint32_t>(std::strtoul(chosen, nullptr, 10));
}

}  // namespace egofocus::test
