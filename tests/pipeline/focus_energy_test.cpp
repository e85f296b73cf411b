// The network's fixed front end against its formulas, pixel by pixel in 64-bit integers.
#include "pipeline/focus_energy.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

using namespace egofocus;

namespace {

struct Maps {
  explicit Maps(std::size_t cells)
      : data(4 * cells), sums{part(0, cells), part(1, cells), part(2, cells), part(3, cells)} {}
  std::span<std::uint16_t> part(std::size_t i, std::size_t cells) {
    return std::span(data).subspan(i * cells, cells);
  }
  std::vector<std::uint16_t> data;
  CellSums sums;
};

std::vector<std::uint8_t> random_plane(int width, int height, unsigned seed, unsigned largest) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> plane(static_cast<std::size_t>(width * height));
  for (auto& n : plane) n = static_cast<std::uint8_t>(random() % (largest + 1));
  return plane;
}

}  // namespace

TEST_CASE("cell sums are those of the formulas, at every size around the cell") {
  for (const unsigned largest : {3u, 127u, 255u}) {
    for (const int width : {4, 5, 7, 8, 61}) {
      for (const int height : {4, 6, 9, 47}) {
        CAPTURE(largest, width, height);
        const auto plane = random_plane(width, height, 7, largest);
        const auto at = [&](int x, int y) {
          return static_cast<std::int64_t>(plane[static_cast<std::size_t>(y * width + x)]);
        };
        const EnergyGrid grid = energy_grid(width, height);
        CHECK(grid.width == (width + 3) / 4);
        CHECK(grid.height == (height + 3) / 4);
        std::vector<std::int64_t> naive(4 * grid.size());
        for (int y = 0; y < height; ++y) {
          for (int x = 0; x < width; ++x) {
            const auto cell = static_cast<std::size_t>(y / 4 * grid.width + x / 4);
            const bool inner_x = x > 0 && x + 1 < width;
            const bool inner_y = y > 0 && y + 1 < height;
            const std::int64_t gx = inner_x ? at(x + 1, y) - at(x - 1, y) : 0;
            const std::int64_t gy = inner_y ? at(x, y + 1) - at(x, y - 1) : 0;
            naive[cell] += gx * gx;
            naive[grid.size() + cell] += gy * gy;
            naive[2 * grid.size() + cell] += at(x, y) * (at(x, y) - 1);
            naive[3 * grid.size() + cell] += at(x, y);
          }
        }
        Maps maps(grid.size());
        std::vector<std::uint32_t> scratch(4 * static_cast<std::size_t>(width));
        sum_cells(plane, width, height, scratch, maps.sums);
        for (std::size_t i = 0; i < naive.size(); ++i)
          REQUIRE(maps.data[i] == std::min<std::int64_t>(naive[i], 65535));
      }
    }
  }
}

// One count that is too large, in any row of a strip or beside it, turns it to wider sums.
TEST_CASE("cell sums with a single large count are those of unsigned integers") {
  constexpr int kWidth = 40;
  constexpr int kHeight = 12;
  for (int y = 0; y < kHeight; ++y) {
    for (const int x : {0, 17, kWidth - 1}) {
      CAPTURE(x, y);
      std::vector<std::uint8_t> plane(static_cast<std::size_t>(kWidth * kHeight), 127);
      plane[static_cast<std::size_t>(y * kWidth + x)] = 255;
      Maps maps(30);
      std::vector<std::uint32_t> scratch(4 * kWidth);
      sum_cells(plane, kWidth, kHeight, scratch, maps.sums);
      const auto cell = static_cast<std::size_t>(y / 4 * 10 + x / 4);
      for (std::size_t i = 0; i < 30; ++i) {
        REQUIRE(maps.sums.counts[i] == 16 * 127 + (i == cell ? 128 : 0));
        REQUIRE(maps.sums.squares[i] ==
                std::min(65535, 16 * 127 * 126 + (i == cell ? 255 * 254 - 127 * 126 : 0)));
      }
      int gradients = 0;
      for (const std::uint16_t sum : maps.sums.gradient_y) gradients += sum;
      CHECK(gradients == ((y > 1) + (y < kHeight - 2)) * 128 * 128);
    }
  }
}

// Four times 128 squared is 2^16.
TEST_CASE("cell sums of one column of equal counts are whole") {
  constexpr int kWidth = 40;
  constexpr int kHeight = 12;
  for (const int count : {127, 128, 129, 181, 255}) {
    CAPTURE(count);
    std::vector<std::uint8_t> plane(static_cast<std::size_t>(kWidth * kHeight));
    for (int y = 0; y < kHeight; ++y)
      plane[static_cast<std::size_t>(y * kWidth + 18)] = static_cast<std::uint8_t>(count);
    Maps maps(30);
    std::vector<std::uint32_t> scratch(4 * kWidth);
    sum_cells(plane, kWidth, kHeight, scratch, maps.sums);
    for (std::size_t cell = 4; cell < 30; cell += 10) {
      CHECK(maps.sums.squares[cell] == std::min(65535, 4 * count * (count - 1)));
      CHECK(maps.sums.gradient_x[cell] == std::min(65535, 8 * count * count));
    }
  }
}

TEST_CASE("gathered maps have the same sum, and say whether it takes both") {
  std::vector<std::uint16_t> first = {0, 1, 65535, 40000, 65535, 0, 7, 65534, 3};
  std::vector<std::uint16_t> second = {0, 2, 0, 40000, 65535, 65535, 8, 1, 4};
  const std::vector<std::uint16_t> a = first;
  const std::vector<std::uint16_t> b = second;
  CHECK(gather(first, second));
  CHECK(second == std::vector<std::uint16_t>{0, 0, 0, 14465, 65535, 0, 0, 0, 0});
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(first[i] + second[i] == a[i] + b[i]);
  CHECK(gather(first, second));  // it is no more than that
  std::vector<std::uint16_t> small = {1, 2, 65500};
  std::vector<std::uint16_t> other = {3, 4, 35};
  CHECK_FALSE(gather(small, other));
  CHECK(small == std::vector<std::uint16_t>{4, 6, 65535});
  CHECK(other == std::vector<std::uint16_t>{0, 0, 0});
}

TEST_CASE("the support is two boxes, zero outside, and the largest sums fit") {
  const EnergyGrid grid{13, 9};
  for (const int side : {1, 3, 5, 7}) {
    CAPTURE(side);
    std::mt19937 random(3);
    std::vector<std::uint16_t> cells(grid.size());
    for (auto& c : cells) c = random() % 4 == 0 ? std::uint16_t{65535} : static_cast<std::uint16_t>(random());
    std::vector<std::int64_t> naive(cells.begin(), cells.end());
    for (int pass = 0; pass < (side == 1 ? 0 : 2); ++pass) {
      std::vector<std::int64_t> sum(naive.size());
      for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x)
          for (int v = std::max(0, y - side / 2); v <= std::min(grid.height - 1, y + side / 2); ++v)
            for (int u = std::max(0, x - side / 2); u <= std::min(grid.width - 1, x + side / 2); ++u)
              sum[static_cast<std::size_t>(y * grid.width + x)] +=
                  naive[static_cast<std::size_t>(v * grid.width + u)];
      naive = sum;
    }
    // Two hypotheses: the cells, and the cells upside down, of which the second map is a copy.
    std::vector<std::uint16_t> maps = cells;
    maps.insert(maps.end(), cells.rbegin(), cells.rend());
    const auto width = static_cast<std::size_t>(grid.width);
    const std::size_t padded = 16;
    std::vector<std::uint32_t> line(2 * (padded + 6));
    std::vector<std::uint32_t> out(2 * padded);
    const bool adds_second[][2] = {{false, false}, {true, false}, {true, true}};
    for (const bool(&adds)[2] : adds_second) {
      for (const bool second : {false, true}) {
        for (int y = 0; y < grid.height; ++y) {
          support_row(maps.data(), second ? maps.data() : nullptr, adds, 2, grid.size(), grid, side, y, line,
                      padded, out.data());
          for (std::size_t x = 0; x < width; ++x) {
            const std::size_t at = static_cast<std::size_t>(y) * width + x;
            REQUIRE(out[x] == (second && adds[0] ? 2 : 1) * naive[at]);
            REQUIRE(out[padded + x] == (second && adds[1] ? 2 : 1) * naive[naive.size() - 1 - at]);
          }
        }
      }
    }
  }
  CHECK(2 * 65535ll * 7 * 7 * 7 * 7 < 4294967296ll);
}

TEST_CASE("halved counts are sums over 2x2 pixels that saturate") {
  for (const int width : {6, 7}) {
    for (const int height : {4, 5}) {
      const auto plane = random_plane(width, height, 11, 120);
      std::vector<std::uint8_t> out(static_cast<std::size_t>((width + 1) / 2 * ((height + 1) / 2)));
      halve_counts(plane, width, height, out);
      bool saturates = false;
      for (int y = 0; y < (height + 1) / 2; ++y) {
        for (int x = 0; x < (width + 1) / 2; ++x) {
          int sum = 0;
          for (int v = 2 * y; v < std::min(2 * y + 2, height); ++v)
            for (int u = 2 * x; u < std::min(2 * x + 2, width); ++u)
              sum += plane[static_cast<std::size_t>(v * width + u)];
          saturates |= sum > 255;
          REQUIRE(out[static_cast<std::size_t>(y * ((width + 1) / 2) + x)] == std::min(sum, 255));
        }
      }
      CHECK(saturates);
    }
  }
}
