#include "kernels/warp_vote.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "exercised_isas.hpp"
#include "kernels/warp_vote_runs.hpp"
#include "warp_vote_case.hpp"

using namespace egofocus;
using namespace egofocus::test;

namespace {

struct Row {
  const char* name;
  Isa isa;
  WarpVoteFunction* run;
};

constexpr Row kRows[] = {
#define EGOFOCUS_WARP_VOTE(suffix, isa) {#suffix, Isa::isa, &warp_vote_u8_##suffix},
#include "kernels/warp_vote.inc"
#undef EGOFOCUS_WARP_VOTE
};

std::vector<WarpVoteShape> shapes() {
  constexpr std::int32_t t = kVoteLane;
  constexpr std::int32_t b = kVoteBlock;
  std::vector<WarpVoteShape> all;
  for (std::int32_t n : {0, 1, t - 1, t, t + 1, 2 * t + 3, b - 1, b, b + 1, 2 * b + t + 3}) {
    all.push_back({n, 2 * t + 3, 7});
    all.push_back({n, t, 5, 13, 29, 3, 10});
  }
  for (std::int32_t width : {0, 1, 2, t - 1, t, t + 1, 2 * t + 3}) {
    for (std::int32_t height : {0, 1, 3}) all.push_back({5 * t + 1, width, height, 3, 1, 0, 9});
  }
  for (std::int32_t k_count = 0; k_count <= 9; ++k_count)
    all.push_back({3 * t, t + 5, 4, 1, 2, 64 - k_count, k_count});
  all.push_back({2000, 346, 260, 38, 100, 0, 64});
  return all;
}

void compare(WarpVoteCase& test_case, const Row& row) {
  const std::int64_t landed = test_case.run(&warp_vote_u8_scalar);
  const std::vector<std::uint8_t> expected = test_case.stack();
  const std::int64_t row_landed = test_case.run(row.run);
  // Not REQUIRE(a == b): a failure would print whole stacks.
  const bool same_bytes = test_case.stack() == expected;
  REQUIRE(same_bytes);
  REQUIRE(row_landed == landed);
  REQUIRE(test_case.scratch_is_zero());
}

}  // namespace

TEST_CASE("warp_vote: the scalar meaning agrees with positions in double and unbounded counts") {
  std::uint32_t seed = test_seed();
  for (const WarpVoteShape& shape : shapes()) {
    for (Fill fill : kEveryFill) {
      INFO("n " << shape.n << " grid " << shape.width << "x" << shape.height << " fill "
                << static_cast<int>(fill) << " seed " << ++seed);
      WarpVoteCase test_case(shape, fill, seed);
      std::vector<std::uint8_t> expected;
      const std::int64_t landed = test_case.expect(expected);
      REQUIRE(test_case.run(&warp_vote_u8_scalar) == landed);
      const bool same_bytes = test_case.stack() == expected;
      REQUIRE(same_bytes);
    }
  }
}

TEST_CASE("warp_vote: every row that this processor runs has the bytes of the scalar one") {
  for (const Row& row : kRows) {
    if (!exercise("warp_vote", row.isa)) continue;
    std::uint32_t seed = test_seed();
    for (const WarpVoteShape& shape : shapes()) {
      for (Fill fill : kEveryFill) {
        INFO(row.name << " n " << shape.n << " grid " << shape.width << "x" << shape.height << " fill "
                      << static_cast<int>(fill) << " seed " << ++seed);
        WarpVoteCase test_case(shape, fill, seed);
        compare(test_case, row);
      }
    }
  }
}

TEST_CASE("warp_vote: random shapes") {
  for (const Row& row : kRows) {
    if (!exercise("warp_vote", row.isa)) continue;
    std::mt19937 random(test_seed());
    const auto below = [&random](std::uint32_t end) { return static_cast<std::int32_t>(random() % end); };
    for (int round = 0; round < 60; ++round) {
      const std::int32_t k_begin = below(65);
      const WarpVoteShape shape{below(700),
                                below(70),
                                below(40),
                                below(40),
                                below(90),
                                k_begin,
                                below(65 - static_cast<std::uint32_t>(k_begin))};
      const std::uint32_t seed = static_cast<std::uint32_t>(random());
      INFO(row.name << " round " << round << " seed " << seed);
      WarpVoteCase test_case(shape, round % 2 == 0 ? Fill::kRandom : Fill::kDense, seed);
      compare(test_case, row);
    }
  }
}

TEST_CASE(
    "warp_vote: calls that share the planes out give the planes of one call, and no scratch is only slow") {
  constexpr std::int32_t kWidth = 37;
  constexpr std::int32_t kHeight = 21;
  constexpr std::int32_t kEvents = 333;
  std::mt19937 random(test_seed());
  std::vector<std::int32_t> u(kEvents), v(kEvents), du(kEvents), dv(kEvents);
  const std::vector<std::uint8_t> k_end(kEvents, 64);
  for (std::size_t i = 0; i < u.size(); ++i) {
    u[i] = static_cast<std::int32_t>(random() % (kWidth << 16));
    v[i] = static_cast<std::int32_t>(random() % (kHeight << 16));
    du[i] = static_cast<std::int32_t>(random() % 60000) - 30000;
    dv[i] = static_cast<std::int32_t>(random() % 60000) - 30000;
  }
  std::vector<std::uint32_t> scratch(kWidth * kHeight);
  const auto stack_of = [&](WarpVoteFunction* run, std::int32_t share, bool with_scratch) {
    std::vector<std::uint8_t> stack(64 * kWidth * kHeight);
    for (std::int32_t k = 0; k < 64; k += share) {
      WarpVote vote;
      vote.u_q16 = u.data();
      vote.v_q16 = v.data();
      vote.du_q16 = du.data();
      vote.dv_q16 = dv.data();
      vote.k_end = k_end.data();
      vote.n = kEvents;
      vote.k_begin = k;
      vote.k_count = std::min(share, 64 - k);
      vote.width = kWidth;
      vote.height = kHeight;
      vote.row_stride = kWidth;
      vote.plane_stride = kWidth * kHeight;
      vote.stack = stack.data() + k * vote.plane_stride;
      vote.scratch = with_scratch ? scratch.data() : nullptr;
      run(vote);
    }
    return stack;
  };
  const std::vector<std::uint8_t> whole = stack_of(&warp_vote_u8_scalar, 64, true);
  for (const Row& row : kRows) {
    if (!exercise("warp_vote", row.isa)) continue;
    INFO(row.name);
    for (std::int32_t share : {1, 3, 8, 22, 64}) {
      const bool same = stack_of(row.run, share, true) == whole;
      REQUIRE(same);
    }
    const bool same_without_scratch = stack_of(row.run, 64, false) == whole;
    REQUIRE(same_without_scratch);
  }
}
