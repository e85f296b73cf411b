// The whole backend on scenes whose answer is known by construction: lines that are sharp under one
// hypothesis.
#include "pipeline/focus.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "support/flat_stack.hpp"

using namespace egofocus;

namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 64;
constexpr double kSpan_px = 20;

// Random dots, one depth for each half of the picture. Under hypothesis k an event at share s of the window
// shifts by (1 - s) * span * k / (D - 1) in kDirection, so a dot that is sharp under k was seen that far
// away.
std::vector<Event> two_depths(int hypotheses, double left_k, double right_k, int empty_from_row) {
  std::mt19937 random(9);
  struct Dot {
    int x, y;
  };
  std::vector<Dot> dots;
  for (int i = 0; i < 700; ++i)
    dots.push_back({static_cast<int>(random() % kWidth),
                    static_cast<int>(random() % static_cast<unsigned>(empty_from_row))});
  std::vector<Event> events;
  const int steps = 20;
  for (int step = 0; step < steps; ++step) {
    const std::int64_t t_us = test::FlatStack::kLength_us * step / (steps - 1);
    const double share = static_cast<double>(step) / (steps - 1);
    for (const Dot& dot : dots) {
      const double k = dot.x < kWidth / 2 ? left_k : right_k;
      const double x = dot.x + (1 - share) * kSpan_px * k / (hypotheses - 1) * -test::FlatStack::kDirection;
      const auto column = static_cast<int>(std::floor(x + 0.5));
      if (column < 0 || column >= kWidth) continue;
      events.push_back({t_us, static_cast<std::uint16_t>(column), static_cast<std::uint16_t>(dot.y), 1});
    }
  }
  return events;
}

struct Result {
  CellGrid cells;
  std::vector<std::uint16_t> index_q8;
  std::vector<std::uint8_t> confidence;
};

Result run(const test::FlatStack& stack, FocusConfig config, int threads) {
  Config all = stack.config;
  all.focus = config;
  test::RoomyArena arena;
  Focus focus(all, threads, *arena);
  WorkerPool pool;
  REQUIRE(pool.start(threads, 0, -1).ok());
  // A baseline with plenty of parallax everywhere.
  HypothesisLadder ladder;
  ladder.step_per_m = 1;
  ladder.count = all.ladder.hypotheses;
  const CellDepth depth = focus.run(*stack.warp, ladder, {1, 0, 0}, pool);
  return {depth.cells,
          {depth.index_q8.begin(), depth.index_q8.end()},
          {depth.confidence.begin(), depth.confidence.end()}};
}

double worst_error(const Result& r, int x0, int x1, int y0, int y1, double k) {
  double worst = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const auto at = static_cast<std::size_t>(y * r.cells.width + x);
      worst = std::max(worst, std::abs(r.index_q8[at] / 256.0 - k));
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("each region's own hypothesis comes back, for every cost, smoothed or not") {
  const int hypotheses = 32;
  const test::FlatStack stack(kWidth, kHeight, hypotheses, kSpan_px, two_depths(hypotheses, 6, 23, 44));
  for (FocusCost cost :
       {FocusCost::kGradient, FocusCost::kVariance, FocusCost::kSosa, FocusCost::kSoe, FocusCost::kSti}) {
    for (bool smoothing : {true, false}) {
      FocusConfig config;
      config.cost = cost;
      config.smoothing = smoothing;
      const Result r = run(stack, config, 1);
      INFO("cost " << static_cast<int>(cost) << ", smoothing " << smoothing);
      REQUIRE(r.cells.width == kWidth / 2);
      REQUIRE(r.cells.height == kHeight / 2);
      // Away from the seam and from the border that dots leave through.
      CHECK(worst_error(r, 11, 18, 3, 18, 6) <= 1.5);
      CHECK(worst_error(r, 32, 44, 3, 18, 23) <= 1.5);
      for (int y = 3; y < 18; ++y) CHECK(r.confidence[static_cast<std::size_t>(y * r.cells.width + 38)] > 5);
      // Below, no events and no support: no estimate. 22 rows of cells have dots; support reaches 6 further.
      for (int y = 28; y < 32; ++y) {
        for (int x = 0; x < r.cells.width; ++x)
          REQUIRE(r.confidence[static_cast<std::size_t>(y * r.cells.width + x)] == 0);
      }
    }
  }
}

TEST_CASE("the backend gives the same bytes for any number of threads") {
  const test::FlatStack stack(kWidth, kHeight, 24, kSpan_px, two_depths(24, 3, 17, 64));
  for (bool smoothing : {true, false}) {
    FocusConfig config;
    config.smoothing = smoothing;
    const Result one = run(stack, config, 1);
    for (int threads : {2, 3}) {
      const Result more = run(stack, config, threads);
      CHECK(more.index_q8 == one.index_q8);
      CHECK(more.confidence == one.confidence);
    }
  }
}

TEST_CASE("without any event nothing has an estimate") {
  const test::FlatStack stack(kWidth, kHeight, 16, kSpan_px, {});
  for (std::uint8_t c : run(stack, {}, 1).confidence) REQUIRE(c == 0);
}

TEST_CASE("a ladder of 8 does not make every middle peak fully certain") {
  // Pure noise: no hypothesis stands out, wherever the best one happens to lie.
  std::mt19937 random(2);
  std::vector<Event> events;
  for (int i = 0; i < 6000; ++i)
    events.push_back({test::FlatStack::kLength_us * i / 6000, static_cast<std::uint16_t>(random() % kWidth),
                      static_cast<std::uint16_t>(random() % kHeight), 1});
  const test::FlatStack stack(kWidth, kHeight, 8, kSpan_px, events);
  const Result r = run(stack, {}, 1);
  std::size_t certain = 0;
  for (std::uint8_t c : r.confidence) certain += c == 255;
  CHECK(certain * 20 < r.confidence.size());
}
