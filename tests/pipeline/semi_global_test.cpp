// Semi-global smoothing against Hirschmueller's equation 13 written as a recursion in plain ints.
#include "pipeline/semi_global.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "support/arena_block.hpp"

using namespace egofocus;

namespace {

constexpr int kP1 = 20;
constexpr int kP2 = 120;

// One path in direction (dx, dy) through the whole volume, added to `sums`.
void add_path(const std::vector<std::uint8_t>& q, int width, int height, int depth, int dx, int dy,
              std::vector<int>& sums) {
  std::vector<int> l(q.size());
  const auto index = [&](int x, int y, int k) {
    return static_cast<std::size_t>((y * width + x) * depth + k);
  };
  for (int step = 0; step < width * height; ++step) {
    const int x = dx >= 0 ? step % width : width - 1 - step % width;
    const int y = dy >= 0 ? step / width : height - 1 - step / width;
    const int bx = x - dx;
    const int by = y - dy;
    const bool first = bx < 0 || by < 0 || bx >= width || by >= height;
    int smallest = 1 << 30;
    for (int k = 0; !first && k < depth; ++k) smallest = std::min(smallest, l[index(bx, by, k)]);
    for (int k = 0; k < depth; ++k) {
      int value = q[index(x, y, k)];
      if (!first) {
        int best = smallest + kP2;
        best = std::min(best, l[index(bx, by, k)]);
        if (k > 0) best = std::min(best, l[index(bx, by, k - 1)] + kP1);
        if (k + 1 < depth) best = std::min(best, l[index(bx, by, k + 1)] + kP1);
        value += best - smallest;
      }
      l[index(x, y, k)] = value;
      sums[index(x, y, k)] += value;
    }
  }
}

void compare(int width, int height, int depth, const std::vector<std::uint8_t>& penalty) {
  std::vector<int> truth(penalty.size());
  for (const auto& d : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}})
    add_path(penalty, width, height, depth, d.first, d.second, truth);
  for (int parts : {1, 2, 3, 8}) {
    test::RoomyArena arena;
    SemiGlobal smoothing({width, height}, depth, parts, *arena);
    for (int again = 0; again < 2; ++again) {  // nothing is left from the tick before
      for (int part = parts - 1; part >= 0; --part) smoothing.along_rows(penalty, part, parts);
      for (int part = parts - 1; part >= 0; --part) smoothing.along_columns(penalty, part, parts);
    }
    const auto sums = smoothing.sums();
    REQUIRE(sums.size() == truth.size());
    std::size_t differ = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) differ += sums[i] != truth[i];
    INFO(width << " x " << height << " x " << depth << ", parts " << parts);
    CHECK(differ == 0);
  }
}

}  // namespace

TEST_CASE("semi-global sums are those of the plain recursion, for any number of parts") {
  std::mt19937 random(1);
  for (const auto& size :
       {std::pair{1, 1}, std::pair{1, 9}, std::pair{7, 1}, std::pair{13, 11}, std::pair{30, 6}}) {
    for (int depth : {8, 16, 64}) {
      std::vector<std::uint8_t> penalty(static_cast<std::size_t>(size.first * size.second * depth));
      SECTION("random") {
        for (auto& p : penalty) p = static_cast<std::uint8_t>(random());
      }
      SECTION("ties everywhere") {
        for (auto& p : penalty) p = static_cast<std::uint8_t>(random() % 2 * 20);
      }
      SECTION("all largest, and all zero") {
        for (std::size_t i = 0; i < penalty.size(); ++i) penalty[i] = i < penalty.size() / 2 ? 255 : 0;
      }
      compare(size.first, size.second, depth, penalty);
    }
  }
}

TEST_CASE("a lone wrong cell gives way to its neighbours") {
  std::vector<std::uint8_t> penalty(9 * 9 * 8, 200);
  for (std::size_t cell = 0; cell < 81; ++cell) penalty[cell * 8 + (cell == 40 ? 7 : 2)] = 100;
  test::RoomyArena arena;
  SemiGlobal smoothing({9, 9}, 8, 1, *arena);
  smoothing.along_rows(penalty, 0, 1);
  smoothing.along_columns(penalty, 0, 1);
  const auto sums = smoothing.sums().subspan(40 * 8, 8);
  CHECK(std::min_element(sums.begin(), sums.end()) - sums.begin() == 2);
}
