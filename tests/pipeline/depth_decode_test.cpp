// Cells to pixels against plain doubles and sorting; metric depth against its definition.
#include "pipeline/depth_decode.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "support/arena_block.hpp"

using namespace egofocus;

namespace {

struct Cells {
  CellGrid grid;
  std::vector<std::uint16_t> index_q8;
  std::vector<std::uint8_t> confidence;
  [[nodiscard]] CellDepth view() const { return {grid, index_q8, confidence}; }
};

struct Picture {
  std::vector<std::uint16_t> inverse_depth;
  std::vector<std::uint8_t> confidence;
};

Picture decode(const Intrinsics& grid, const Cells& cells, int threads) {
  test::RoomyArena arena;
  DepthDecode decoder(grid, true, *arena);
  WorkerPool pool;
  REQUIRE(pool.start(threads, 0, -1).ok());
  const auto pixels = static_cast<std::size_t>(grid.width_px * grid.height_px);
  Picture out{std::vector<std::uint16_t>(pixels, 4711), std::vector<std::uint8_t>(pixels, 77)};
  decoder.run(cells.view(), pool, out.inverse_depth, out.confidence);
  return out;
}

Picture naive(const Intrinsics& grid, const Cells& cells) {
  const int w = cells.grid.width;
  const int h = cells.grid.height;
  const auto index = [&](int x, int y) { return static_cast<std::size_t>(y * w + x); };
  std::vector<int> median(cells.index_q8.size());
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      std::vector<int> around;
      for (int dy = -2; dy <= 2; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
          const bool inside = x + dx >= 0 && x + dx < w && y + dy >= 0 && y + dy < h;
          if (inside && cells.confidence[index(x + dx, y + dy)] > 0)
            around.push_back(cells.index_q8[index(x + dx, y + dy)]);
        }
      }
      std::sort(around.begin(), around.end());
      if (!around.empty()) median[index(x, y)] = around[(around.size() - 1) / 2];
    }
  }
  Picture out;
  for (int y = 0; y < grid.height_px; ++y) {
    for (int x = 0; x < grid.width_px; ++x) {
      const std::size_t own = index(x / 2, y / 2);
      out.confidence.push_back(cells.confidence[own]);
      // Cell centres lie at 2 c + 0.5; the pixel's four nearest ones, with bilinear weights in sixteenths.
      const int x0 = static_cast<int>(std::floor((x - 0.5) / 2));
      const int y0 = static_cast<int>(std::floor((y - 0.5) / 2));
      const double sx = (x - 0.5) / 2 - x0;
      const double sy = (y - 0.5) / 2 - y0;
      double sum = 0;
      for (int j = 0; j < 2; ++j) {
        for (int i = 0; i < 2; ++i) {
          const int cx = std::clamp(x0 + i, 0, w - 1);
          const int cy = std::clamp(y0 + j, 0, h - 1);
          int value = median[index(cx, cy)];
          if (cells.confidence[index(cx, cy)] == 0 || std::abs(value - median[own]) > 512)
            value = median[own];
          sum += (i ? sx : 1 - sx) * (j ? sy : 1 - sy) * value;
        }
      }
      out.inverse_depth.push_back(
          cells.confidence[own] == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(std::floor(sum + 0.5)));
    }
  }
  return out;
}

}  // namespace

TEST_CASE("median and enlargement are those of a plain decoder, at even and odd sizes") {
  std::mt19937 random(3);
  for (const auto& size :
       {std::pair{8, 8}, std::pair{9, 8}, std::pair{8, 11}, std::pair{31, 23}, std::pair{60, 40}}) {
    for (unsigned unknown_of_10 : {0u, 3u, 9u, 10u}) {
      const Intrinsics grid{size.first, size.second, 10, 10, 4, 4};
      Cells cells{cell_grid(grid), {}, {}};
      for (std::size_t i = 0; i < cells.grid.size(); ++i) {
        const unsigned base = random() % 5 == 0 ? 9000u : 2000u;  // edges, and steps around two hypotheses
        cells.index_q8.push_back(static_cast<std::uint16_t>(base + random() % 1200));
        cells.confidence.push_back(
            random() % 10 < unknown_of_10 ? std::uint8_t{0} : static_cast<std::uint8_t>(1 + random() % 255));
      }
      const Picture truth = naive(grid, cells);
      for (int threads : {1, 2, 3}) {
        const Picture got = decode(grid, cells, threads);
        INFO(size.first << " x " << size.second << ", unknown " << unknown_of_10 << ", threads " << threads);
        CHECK(got.inverse_depth == truth.inverse_depth);
        CHECK(got.confidence == truth.confidence);
      }
    }
  }
}

TEST_CASE("a lone wrong cell disappears, a depth edge stays sharp, infinity stays infinity") {
  const Intrinsics grid{40, 20, 10, 10, 4, 4};
  Cells cells{cell_grid(grid), std::vector<std::uint16_t>(200, 0), std::vector<std::uint8_t>(200, 9)};
  for (std::size_t i = 0; i < 200; ++i) cells.index_q8[i] = i % 20 < 10 ? 0 : 63 * 256;
  cells.index_q8[5 * 20 + 4] = 5000;
  const Picture got = decode(grid, cells, 1);
  for (std::size_t i = 0; i < 800; ++i) REQUIRE(got.inverse_depth[i] == (i % 40 < 20 ? 0 : 63 * 256));
}

TEST_CASE("metric depth: unknown is 0, far is clipped, the rest is 1 / rho") {
  const std::uint16_t inverse[] = {0, 0, 1, 100, 400, 16128, 65535};
  const std::uint8_t confidence[] = {0, 1, 255, 3, 0, 1, 8};
  DepthFrame frame;
  frame.inverse_depth_scale_per_m = 0.5 / 16128;
  frame.inverse_depth = inverse;
  frame.confidence = confidence;
  float out[9];
  std::fill(std::begin(out), std::end(out), -1.0f);
  REQUIRE(metric_depth(frame, 80.0f, out) == 7);
  CHECK(out[0] == 0.0f);
  CHECK(out[1] == 80.0f);
  CHECK(out[2] == 80.0f);
  CHECK(out[3] == 80.0f);  // 322 m
  CHECK(out[4] == 0.0f);
  CHECK(out[5] == Approx(2.0f));
  CHECK(out[6] == Approx(16128 / 65535.0 / 0.5));
  CHECK(out[7] == -1.0f);
  REQUIRE(metric_depth(frame, 1000.0f, {out, 4}) == 4);
  CHECK(out[3] == Approx(322.56f));
  CHECK(out[1] == 1000.0f);
  REQUIRE(metric_depth(frame, std::numeric_limits<float>::infinity(), {out, 4}) == 4);
  CHECK(std::isinf(out[1]));
  CHECK(out[3] == Approx(322.56f));
  DepthFrame blank;
  CHECK(metric_depth(blank, 80.0f, out) == 0);
}
