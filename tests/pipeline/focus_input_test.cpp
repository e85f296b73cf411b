// The network's input: one cell by hand, random windows against the formulas in doubles, bytes that no split
// and no processor changes.
#include "pipeline/focus_input.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "pipeline/fixed_point.hpp"
#include "support/arena_block.hpp"

using namespace egofocus;

namespace {

constexpr int kWidth = 61;
constexpr int kHeight = 38;
constexpr Intrinsics kGrid{kWidth, kHeight, 80, 90, 30.5, 18.25};

FocusInputConfig config_of(std::vector<FocusMap> maps) {
  FocusInputConfig config;
  config.map_count = static_cast<std::int32_t>(maps.size());
  std::copy(maps.begin(), maps.end(), config.maps);
  return config;
}

const FocusInputConfig kBase = config_of({{FocusMapKind::kGradient, 1},
                                          {FocusMapKind::kGradient, 3},
                                          {FocusMapKind::kGradientX, 5},
                                          {FocusMapKind::kGradientY, 7},
                                          {FocusMapKind::kSquares, 7}});

std::vector<std::uint8_t> random_planes(int hypotheses, unsigned seed, unsigned one_in, unsigned largest) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> planes(static_cast<std::size_t>(hypotheses * kWidth * kHeight));
  for (auto& n : planes) n = random() % one_in == 0 ? static_cast<std::uint8_t>(random() % (largest + 1)) : 0;
  return planes;
}

struct Result {
  std::vector<std::uint8_t> focus;
  std::vector<std::uint8_t> context;
  EnergyGrid cells;
};

Result run(const FocusInputConfig& config, int hypotheses, const std::vector<std::uint8_t>& planes,
           int threads = 1) {
  Arena counter;
  { const FocusInput counted(config, kGrid, hypotheses, threads, counter); }
  const test::ArenaBlock block(counter.used_bytes());
  Arena arena(block.span());
  FocusInput input(config, kGrid, hypotheses, threads, arena);
  REQUIRE(arena.used_bytes() == counter.used_bytes());
  WorkerPool pool;
  REQUIRE(pool.start(threads, 0, -1).ok());
  HypothesisLadder ladder;
  ladder.count = static_cast<std::int32_t>(planes.size() / (kWidth * kHeight));
  ladder.step_per_m = 0.125;
  input.run(planes, ladder, {-0.125, 0.0625, 0.5}, pool);
  return {{input.focus().begin(), input.focus().end()},
          {input.context().begin(), input.context().end()},
          input.cells()};
}

// The byte that so many steps would be, were it not rounded.
double unrounded(double steps) {
  return 64 + std::clamp(steps, -64.0, 63.0);
}

// Two boxes, zero outside, of the map's energy in every cell of hypothesis k.
std::vector<double> supported(const std::vector<std::uint8_t>& planes, int k, const EnergyGrid& grid,
                              int side, const FocusMapKind* kind) {
  const auto at = [&](int x, int y) {
    return static_cast<double>(planes[static_cast<std::size_t>((k * kHeight + y) * kWidth + x)]);
  };
  std::vector<double> sums(grid.size());
  std::vector<double> other(grid.size());  // saturates on its own
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto cell = static_cast<std::size_t>(y / 4 * grid.width + x / 4);
      const double gx = x > 0 && x + 1 < kWidth ? at(x + 1, y) - at(x - 1, y) : 0;
      const double gy = y > 0 && y + 1 < kHeight ? at(x, y + 1) - at(x, y - 1) : 0;
      if (kind == nullptr) sums[cell] += at(x, y);
      if (kind != nullptr && *kind == FocusMapKind::kSquares) sums[cell] += at(x, y) * (at(x, y) - 1);
      if (kind != nullptr && (*kind == FocusMapKind::kGradient || *kind == FocusMapKind::kGradientX))
        sums[cell] += gx * gx;
      if (kind != nullptr && (*kind == FocusMapKind::kGradient || *kind == FocusMapKind::kGradientY))
        other[cell] += gy * gy;
    }
  }
  for (std::size_t i = 0; i < sums.size(); ++i)
    sums[i] = std::min(sums[i], 65535.0) + std::min(other[i], 65535.0);
  for (int pass = 0; pass < (side == 1 ? 0 : 2); ++pass) {
    std::vector<double> box(sums.size());
    for (int y = 0; y < grid.height; ++y)
      for (int x = 0; x < grid.width; ++x)
        for (int v = std::max(0, y - side / 2); v <= std::min(grid.height - 1, y + side / 2); ++v)
          for (int u = std::max(0, x - side / 2); u <= std::min(grid.width - 1, x + side / 2); ++u)
            box[static_cast<std::size_t>(y * grid.width + x)] +=
                sums[static_cast<std::size_t>(v * grid.width + u)];
    sums = box;
  }
  return sums;
}

struct Distance {
  double z = 0;
  double contrast = 0;
};

// Largest distances, in steps, of one map's bytes from the formulas.
Distance worst_error(const Result& r, const std::vector<std::uint8_t>& planes, const FocusInputConfig& config,
                     std::size_t m) {
  const FocusMap& map = config.maps[m];
  const auto used = planes.size() / (kWidth * kHeight);
  const auto maps = static_cast<std::size_t>(config.map_count);
  const double floor_events = config.floor_events_milli / 1000.0;
  const double n = 16 * std::pow(map.side, 4);
  std::vector<std::vector<double>> ratio(used);
  std::vector<double> density(r.cells.size());
  for (std::size_t k = 0; k < used; ++k) {
    ratio[k] = supported(planes, static_cast<int>(k), r.cells, map.side, &map.kind);
    const auto counts = supported(planes, static_cast<int>(k), r.cells, map.side, nullptr);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      ratio[k][i] /= counts[i] + n * floor_events;
      density[i] += counts[i] / n / static_cast<double>(used);
    }
  }
  Distance worst;
  for (std::size_t i = 0; i < density.size(); ++i) {
    double mean = 0;
    double variance = 0;
    for (std::size_t k = 0; k < used; ++k) mean += ratio[k][i] / static_cast<double>(used);
    for (std::size_t k = 0; k < used; ++k)
      variance += (ratio[k][i] - mean) * (ratio[k][i] - mean) / static_cast<double>(used);
    const double pixels = map.side == 1 ? 16 : 36.0 * map.side * map.side;
    const double q = std::sqrt(4 / (pixels * (density[i] + floor_events)));
    for (std::size_t k = 0; k < used; ++k) {
      const double z = (ratio[k][i] - mean) / (std::sqrt(variance) + config.floor_noise_milli / 1000.0 * q);
      worst.z = std::max(worst.z, std::abs(unrounded(8 * z) - r.focus[(k * maps + m) * density.size() + i]));
    }
    const double contrast = 32 * std::log2(1 + std::sqrt(variance) / q) / 4;
    worst.contrast =
        std::max(worst.contrast, std::abs(unrounded(contrast) - r.context[(2 + m) * density.size() + i]));
  }
  return worst;
}

std::uint32_t hash(const std::vector<std::uint8_t>& bytes, std::uint32_t sum = 2166136261u) {
  for (const std::uint8_t b : bytes) sum = (sum ^ b) * 16777619u;
  return sum;
}

}  // namespace

TEST_CASE("one cell of four hypotheses, by hand") {
  // floor_events 1/2: F = 16/2 * 2^15 = 2^18, c = 45, R in 1/2^13, g = 3, N = 2^49.
  const SupportScale scale = support_scale(1, 500);
  CHECK(scale.floor == 1u << 18);
  CHECK(scale.reciprocal_shift == 45);
  CHECK(scale.noise == std::uint64_t{1} << 49);
  CHECK(scale.noise_shift == 2);
  // Eight events each: D = 2^19. The cell stands first in a group of empty ones.
  std::vector<std::uint32_t> counts(4 * kCellGroup);
  for (std::size_t k = 0; k < 4; ++k) counts[k * kCellGroup] = 8;
  std::vector<std::uint32_t> reciprocal(counts.size());
  reciprocals(scale, counts, reciprocal.data());
  CHECK(reciprocal[0] == 1u << 26);
  CHECK(reciprocal[1] == 1u << 27);
  std::uint32_t mean[kCellGroup], half[kCellGroup], shift[kCellGroup], square[kCellGroup], noise[kCellGroup];
  std::int32_t low[kCellGroup], high[kCellGroup];
  std::int16_t limit[kCellGroup];
  std::uint16_t factor[kCellGroup], gain[kCellGroup];
  const SharpnessRow row{mean, low, high, half, shift, square, noise, limit, factor, gain};
  const std::uint32_t count_sum[kCellGroup] = {32};
  noise_row(scale, count_sum, 4, noise);
  CHECK(noise[0] == 1u << 17);  // q = sqrt(4 / (16 (1/2 + 1/2))) = 1/2
  // R = 1/2, 1, 0, 1/2; h = 0, u = 0, 4096, -4096, 0; V = 2^25, sd = 4 floor(sqrt(2^29)) = 92680;
  // the divisor is 92680 + 2^17 = 223752, G = 9597, and 4096 * 9597 / 2^16 = 599 makes 5 steps.
  std::vector<std::uint32_t> ratio(counts.size());
  ratio[0] = 8;
  ratio[kCellGroup] = 16;
  ratio[3 * kCellGroup] = 8;
  std::vector<std::int16_t> deviation(counts.size());
  std::vector<std::uint8_t> z(4);
  std::uint8_t contrast = 0;
  sharpness_row(scale, 1u << 20, 4, reciprocal, ratio, deviation, row, 1, z.data(), 1, &contrast);
  for (std::size_t k = 0; k < 4; ++k) {
    CAPTURE(k);
    CHECK(ratio[k * kCellGroup] == std::vector<std::uint32_t>{1u << 12, 1u << 13, 0, 1u << 12}[k]);
    CHECK(deviation[k * kCellGroup] == std::vector<std::int16_t>{0, 4096, -4096, 0}[k]);
  }
  CHECK(gain[0] == 9597);
  CHECK(z == std::vector<std::uint8_t>{64, 69, 59, 64});  // 8 * 0.5 / (0.354 + 0.5) = 4.7
  CHECK(contrast == 64 + 6);                              // 8 log2(1.707) = 6.2
  std::uint8_t density = 0;
  density_row(scale, {count_sum, 1}, 4, &density);
  CHECK(density == 64 + 25);  // 8 log2(1 + 8) = 25.4
}

TEST_CASE("roots and logarithms") {
  // Around every square: what a root in floating point could get wrong.
  for (std::uint64_t n = 0; n <= 65536; ++n) {
    for (const std::uint64_t x : {n * n - 1, n * n, n * n + n, n * n + 2 * n}) {
      if (x > 0xffffffff) continue;
      const std::uint64_t root = floor_square_root_u32(static_cast<std::uint32_t>(x));
      REQUIRE(root * root <= x);
      REQUIRE((root + 1) * (root + 1) > x);
    }
  }
  for (std::uint32_t i = 0; i < 256; ++i)
    CHECK(kLog2Table.entry_q8[i] == std::floor(256 * std::log2(1 + (i + 0.5) / 256) + 0.5));
  for (const double x : {1.0, 2.0, 3.0, 255.0, 256.0, 12345.0, 4294967295.0})
    CHECK(std::abs(log2_q8(static_cast<std::uint32_t>(x)) - 256 * std::log2(x)) < 1.3);
}

TEST_CASE("focus and contrast are the formulas', to less than a step") {
  struct Kind {
    int used, hypotheses;
    unsigned one_in, largest;
  };
  for (const Kind& kind : {Kind{8, 8, 6, 3}, Kind{24, 48, 2, 9}, Kind{64, 64, 40, 1}, Kind{1, 32, 3, 4},
                           Kind{2, 8, 3, 4}, Kind{16, 16, 3, 40}}) {
    const auto planes = random_planes(kind.used, 5, kind.one_in, kind.largest);
    for (const int floor_events : {20, 50, 1000}) {
      FocusInputConfig config = kBase;
      config.floor_events_milli = floor_events;
      config.floor_noise_milli = floor_events == 50 ? 1000 : 250;
      const Result r = run(config, kind.hypotheses, planes);
      for (std::size_t m = 0; m < 5; ++m) {
        CAPTURE(kind.used, kind.largest, floor_events, m);
        const Distance worst = worst_error(r, planes, config, m);
        CHECK(worst.z < 0.8);
        CHECK(worst.contrast < 0.8);
      }
    }
  }
}

TEST_CASE("what was left out is zero, and context tells the parallax") {
  const Result r = run(kBase, 32, random_planes(8, 3, 4, 5));
  const std::size_t cells = r.cells.size();
  CHECK(std::any_of(r.focus.begin(), r.focus.begin() + static_cast<std::ptrdiff_t>(8 * 5 * cells),
                    [](std::uint8_t z) { return z != kInputZero; }));
  CHECK(std::all_of(r.focus.begin() + static_cast<std::ptrdiff_t>(8 * 5 * cells), r.focus.end(),
                    [](std::uint8_t z) { return z == kInputZero; }));
  // Baseline times step: (-1/64, 1/128, 1/16). Cell (3, 2) has its centre at (13.5, 9.5).
  const auto at = static_cast<std::size_t>(2 * r.cells.width + 3);
  const double x = 80 / -64.0 - (13.5 - 30.5) / 16;
  const double y = 90 / 128.0 - (9.5 - 18.25) / 16;
  CHECK(std::abs(r.context[7 * cells + at] - unrounded(32 * x)) <= 0.6);
  CHECK(std::abs(r.context[8 * cells + at] - unrounded(32 * y)) <= 0.6);
  CHECK(std::abs(r.context[9 * cells + at] - unrounded(32 * std::hypot(x, y))) <= 0.6);
  CHECK(r.context[10 * cells + at] == 64 + 8);  // 8 of 32
}

TEST_CASE("no events, one event, and pixels that are full") {
  const auto none = std::vector<std::uint8_t>(16 * kWidth * kHeight);
  const Result empty = run(kBase, 16, none);
  CHECK(std::all_of(empty.focus.begin(), empty.focus.end(), [](std::uint8_t z) { return z == kInputZero; }));
  CHECK(std::all_of(empty.context.begin(), empty.context.begin() + 7 * 160,
                    [](std::uint8_t c) { return c == kInputZero; }));
  auto one = none;
  one[static_cast<std::size_t>((4 * kHeight + 20) * kWidth + 30)] = 1;
  CHECK(worst_error(run(kBase, 16, one), one, kBase, 3).z < 0.7);
  auto full = none;
  for (std::size_t i = 0; i < full.size(); ++i) full[i] = (i / 2 + i / kWidth / 2) % 2 ? 255 : 0;
  for (std::size_t i = 0; i < 5 * kWidth * kHeight; ++i) full[i] = 255;
  // A pixel that fired all the time, under one hypothesis: R saturates in the cell beside it.
  auto hot = random_planes(16, 8, 20, 2);
  hot[static_cast<std::size_t>(16 * kWidth + 24)] = 255;
  for (std::size_t m = 0; m < 5; ++m) {
    CAPTURE(m);
    const Distance at_full = worst_error(run(kBase, 16, full), full, kBase, m);
    CHECK(at_full.z < 0.8);
    CHECK(at_full.contrast < 0.8);
    const Distance at_hot = worst_error(run(kBase, 16, hot), hot, kBase, m);
    CHECK(at_hot.z < 0.8);
    CHECK(at_hot.contrast < (m == 0 ? 27 : 0.8));  // 8 log2(81281 / 8191) = 26.5
  }
}

TEST_CASE("the same bytes for any number of threads, on any processor") {
  const auto planes = random_planes(24, 17, 5, 12);
  const Result one = run(kBase, 32, planes);
  for (const int threads : {2, 3, 8}) {
    const Result more = run(kBase, 32, planes, threads);
    CHECK(more.focus == one.focus);
    CHECK(more.context == one.context);
  }
  CHECK(hash(one.context, hash(one.focus)) == 0xb4174e09u);
}

TEST_CASE("settings that the integers do not hold are refused") {
  CHECK(FocusInput::check(kBase).ok());
  const auto refused = [](auto change) {
    FocusInputConfig config = kBase;
    change(config);
    return FocusInput::check(config).code() == StatusCode::kBadFocus;
  };
  CHECK(refused([](FocusInputConfig& c) { c.map_count = 0; }));
  CHECK(refused([](FocusInputConfig& c) { c.map_count = 9; }));
  CHECK(refused([](FocusInputConfig& c) { c.maps[1].side = 2; }));
  CHECK(refused([](FocusInputConfig& c) { c.maps[1].side = 9; }));
  CHECK(refused([](FocusInputConfig& c) { c.maps[4].kind = static_cast<FocusMapKind>(4); }));
  CHECK(refused([](FocusInputConfig& c) { c.floor_events_milli = 19; }));
  CHECK(refused([](FocusInputConfig& c) { c.floor_events_milli = 2001; }));
  CHECK(refused([](FocusInputConfig& c) { c.floor_noise_milli = 99; }));
  CHECK(refused([](FocusInputConfig& c) { c.floor_noise_milli = 8001; }));
}
