// Each focus cost against the formulas of its header, summed plainly in 64-bit integers and doubles.
#include "pipeline/focus_cost.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "support/flat_stack.hpp"

using namespace egofocus;

namespace {

struct Naive {
  std::vector<double> cost;
  std::vector<double> tolerance;
  std::vector<std::int64_t> counts;
};

// g of one pixel with I events; the gradient's and sti's are made elsewhere.
double numerator(FocusCost cost, double n) {
  switch (cost) {
    case FocusCost::kVariance:
      return 4 * n * (n - 1);
    case FocusCost::kSosa:
      return 256 * (std::exp(-0.4 * n) - 1 + (1 - std::exp(-0.4)) * n);
    default: {  // soe, tangent from 60 on
      const double e = n <= 60 ? std::exp(0.1 * n) : std::exp(6.0) * (1 + 0.1 * (n - 60));
      return 16 * (e - 1 - (std::exp(0.1) - 1) * n);
    }
  }
}

// Its mean under Poisson events of density l, by summing the series: not by the closed forms of the header.
double poisson_mean(FocusCost cost, double l) {
  if (cost == FocusCost::kGradient) return 0;
  if (cost == FocusCost::kSti) return 84 * (1 - std::exp(-l));
  double sum = 0;
  double p = std::exp(-l);
  for (int n = 0; n < 60; ++n) {
    sum += p * numerator(cost, n);
    p *= l / (n + 1);
  }
  return sum;
}

std::vector<std::int64_t> twice_boxed(std::vector<std::int64_t> cells, int width, int height, int side) {
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<std::int64_t> out(cells.size());
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (int v = y - side / 2; v <= y + side / 2; ++v) {
          for (int u = x - side / 2; u <= x + side / 2; ++u) {
            if (u >= 0 && u < width && v >= 0 && v < height)
              out[static_cast<std::size_t>(y * width + x)] += cells[static_cast<std::size_t>(v * width + u)];
          }
        }
      }
    }
    cells = out;
  }
  return cells;
}

Naive naive_cost(const Warp& warp, FocusCost cost, std::int32_t k, int width, int height, int side) {
  const auto plane = warp.plane(k);
  const auto at = [&](int x, int y) {
    return static_cast<std::int64_t>(plane[static_cast<std::size_t>(y * width + x)]);
  };
  std::vector<std::int64_t> time_sum(plane.size());
  std::vector<std::int64_t> time_count(plane.size());
  const LandingLines& lines = warp.lines();
  for (std::size_t i = 0; i < static_cast<std::size_t>(lines.count); ++i) {
    if (k >= lines.k_end[i]) continue;
    const double u = std::floor((lines.u_q16[i] + 1.0 * k * lines.du_q16[i]) / 65536 + 0.5);
    const double v = std::floor((lines.v_q16[i] + 1.0 * k * lines.dv_q16[i]) / 65536 + 0.5);
    if (u < 0 || v < 0 || u >= width || v >= height) continue;
    time_sum[static_cast<std::size_t>(v * width + u)] += lines.time_u8[i];
    ++time_count[static_cast<std::size_t>(v * width + u)];
  }
  const int cells_x = (width + 1) / 2;
  const int cells_y = (height + 1) / 2;
  std::vector<std::int64_t> g(static_cast<std::size_t>(cells_x * cells_y));
  std::vector<std::int64_t> counts(g.size());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::int64_t value = 0;
      if (cost == FocusCost::kGradient) {
        const std::int64_t dx = x > 0 && x < width - 1 ? at(x + 1, y) - at(x - 1, y) : 0;
        const std::int64_t dy = y > 0 && y < height - 1 ? at(x, y + 1) - at(x, y - 1) : 0;
        value = dx * dx + dy * dy;
      } else if (cost == FocusCost::kSti) {
        const auto i = static_cast<std::size_t>(y * width + x);
        if (time_count[i] > 0) {
          const std::int64_t t = std::min<std::int64_t>(time_sum[i] / time_count[i] - 127, 127);
          value = at(x, y) * (t * t / 64);
        }
      } else {
        value = std::llround(numerator(cost, static_cast<double>(at(x, y))));
      }
      g[static_cast<std::size_t>(y / 2 * cells_x + x / 2)] += value;
      counts[static_cast<std::size_t>(y / 2 * cells_x + x / 2)] += at(x, y);
    }
  }
  const auto a = twice_boxed(g, cells_x, cells_y, side);
  Naive out;
  out.counts = twice_boxed(counts, cells_x, cells_y, side);
  const double n = 4 * std::pow(side, 4);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto s = static_cast<double>(out.counts[i]);
    const double expected = n * poisson_mean(cost, s / n);
    const double net =
        cost == FocusCost::kSti ? expected - static_cast<double>(a[i]) : static_cast<double>(a[i]) - expected;
    const double below = s + std::floor(n / 20);
    out.cost.push_back(std::min(65535.0, 256 * std::max(0.0, net) / below));
    // The table of J is linear between densities 1/18 apart at most: h^2 / 8 of the largest second
    // derivative.
    const double bend = cost == FocusCost::kGradient ? 0 : cost == FocusCost::kSti ? 84 : 28;
    const double table = n * bend / 8 / (18 * 18);
    // Sums of 15 x 15 lose 4 bits per row.
    const double shift = side == 15 ? 16.0 * (15 * 15 + 2) : 0;
    out.tolerance.push_back(1 + 256 * (table + shift) / below);
  }
  return out;
}

std::vector<Event> random_events(int width, int height, int n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Event> events;
  for (int i = 0; i < n; ++i) {
    Event e{test::FlatStack::kLength_us * i / n,
            static_cast<std::uint16_t>(random() % static_cast<unsigned>(width)),
            static_cast<std::uint16_t>(random() % static_cast<unsigned>(height)), 1};
    if (i % 4 == 0) e.x = static_cast<std::uint16_t>(width / 3);  // an edge
    events.push_back(e);
  }
  return events;
}

void compare(FocusCost cost, int side, int width, int height, const std::vector<Event>& events) {
  const test::FlatStack stack(width, height, 8, 6, events);
  FocusConfig config;
  config.cost = cost;
  config.support_cells = side;
  REQUIRE(FocusCostPlane::check(config).ok());
  test::RoomyArena arena;
  FocusCostPlane plane(config, stack.config.camera.intrinsics, 2, *arena);
  const std::size_t cells = cell_grid(stack.config.camera.intrinsics).size();
  std::vector<std::uint16_t> got(cells);
  std::vector<std::uint16_t> density(cells);
  std::vector<std::uint16_t> again(cells);
  const double n = 4 * std::pow(side, 4);
  double largest = 0;
  for (std::int32_t k : {0, 3, 7}) {
    plane.compute(*stack.warp, k, 0, got, density);
    const Naive truth = naive_cost(*stack.warp, cost, k, width, height, side);
    REQUIRE(truth.cost.size() == cells);
    for (std::size_t i = 0; i < cells; ++i) {
      INFO("cost " << static_cast<int>(cost) << ", support " << side << ", k " << k << ", cell " << i);
      if (cost == FocusCost::kGradient && side < 15) {
        REQUIRE(got[i] == static_cast<std::uint16_t>(truth.cost[i]));  // integers all the way: exact
      } else {
        REQUIRE(std::abs(got[i] - truth.cost[i]) <= truth.tolerance[i]);
      }
      REQUIRE(density[i] == static_cast<std::uint16_t>(256.0 * static_cast<double>(truth.counts[i]) / n));
      largest = std::max(largest, truth.cost[i]);
    }
    plane.compute(*stack.warp, k, 1, again, density);  // another part's scratch: the same bytes
    REQUIRE(again == got);
  }
  CHECK(largest > 0);
}

constexpr FocusCost kAll[] = {FocusCost::kGradient, FocusCost::kVariance, FocusCost::kSosa, FocusCost::kSoe,
                              FocusCost::kSti};

}  // namespace

TEST_CASE("every focus cost is what its header says, for each support, at borders and odd sizes") {
  for (FocusCost cost : kAll) {
    for (int side : {3, 7, 15}) {
      compare(cost, side, 53, 41, random_events(53, 41, 1500, 3));  // under one event per pixel
      compare(cost, side, 33, 10, random_events(33, 10, 900, 4));   // a support larger than the picture
    }
  }
}

TEST_CASE("saturated counts overflow nothing") {
  // Every second column at 255: the largest gradient and the largest sums there are.
  std::vector<Event> events;
  const int width = 40;
  const int height = 36;
  for (int i = 0; i < 260; ++i) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; x += 4) {
        for (int side : {0, 1})
          events.push_back({test::FlatStack::kLength_us, static_cast<std::uint16_t>(x + side),
                            static_cast<std::uint16_t>(y), 1});
      }
    }
  }
  const test::FlatStack stack(width, height, 8, 6, events);
  for (FocusCost cost : {FocusCost::kGradient, FocusCost::kVariance, FocusCost::kSosa}) {
    for (int side : {3, 15}) {
      FocusConfig config;
      config.cost = cost;
      config.support_cells = side;
      test::RoomyArena arena;
      FocusCostPlane plane(config, stack.config.camera.intrinsics, 1, *arena);
      std::vector<std::uint16_t> got(20 * 18);
      std::vector<std::uint16_t> density(20 * 18);
      plane.compute(*stack.warp, 0, 0, got, density);
      const Naive truth = naive_cost(*stack.warp, cost, 0, width, height, side);
      for (std::size_t i = 0; i < got.size(); ++i) {
        INFO("cost " << static_cast<int>(cost) << ", support " << side << ", cell " << i);
        // The Poisson series of the oracle ends at 60 events; only the gradient needs none.
        if (cost == FocusCost::kGradient) REQUIRE(std::abs(got[i] - truth.cost[i]) <= truth.tolerance[i]);
        REQUIRE(density[i] == static_cast<std::uint16_t>(256.0 * static_cast<double>(truth.counts[i]) /
                                                         (4 * std::pow(side, 4))));
      }
      if (cost == FocusCost::kGradient) CHECK(truth.cost[9 * 20 + 10] == 65535);
    }
  }
}

TEST_CASE("a focus setting that cannot be meant is refused") {
  FocusConfig config;
  CHECK(FocusCostPlane::check(config).ok());
  SECTION("small") {
    config.support_cells = 1;
  }
  SECTION("even") {
    config.support_cells = 8;
  }
  SECTION("large") {
    config.support_cells = 17;
  }
  SECTION("no events") {
    config.min_support_events = 0;
  }
  SECTION("many events") {
    config.min_support_events = 10001;
  }
  SECTION("no such cost") {
    config.cost = static_cast<FocusCost>(5);
  }
  CHECK(FocusCostPlane::check(config).code() == StatusCode::kBadFocus);
}
