#include "pipeline/memory_plan.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "support/arena_block.hpp"

using namespace egofocus;

TEST_CASE("buffers of different steps share memory, those of the same step do not") {
  MemoryPlan plan;
  const auto a = plan.add(1000, 0, 0);
  const auto b = plan.add(500, 0, 1);
  const auto c = plan.add(700, 1, 2);
  const auto d = plan.add(64, 2, 2);
  test::RoomyArena arena;
  plan.place(*arena);
  CHECK(plan.offset(a) == 0);
  CHECK(plan.offset(b) == 1024);  // 1000 in whole cache lines
  CHECK(plan.offset(c) == 0);     // where a was
  CHECK(plan.offset(d) == 704);
  CHECK(plan.bytes() == 1024 + 512);
  CHECK((*arena).used_bytes() == plan.bytes());
  CHECK(plan.arena(c).array<std::uint8_t>(700).size() == 700);
}

TEST_CASE("what a buffer leaves when it shrinks is another's") {
  MemoryPlan plan;
  const auto a = plan.add(1000, 0, 1, 300, 3);
  const auto b = plan.add(600, 2, 3);
  const auto c = plan.add(700, 4, 4);
  test::RoomyArena arena;
  plan.place(*arena);
  CHECK(plan.offset(a) == 0);
  CHECK(plan.offset(b) == 320);
  CHECK(plan.offset(c) == 0);
  CHECK(plan.bytes() == 1024);
  const auto whole = plan.arena(a).array<std::uint8_t>(1024);
  CHECK(plan.arena(a, 960).array<std::uint8_t>(64).data() == whole.data() + 960);
}

TEST_CASE("a plan that only counts has no memory, and the same total") {
  MemoryPlan plan;
  const auto a = plan.add(100, 0, 3);
  Arena counter;
  plan.place(counter);
  CHECK(counter.used_bytes() == 128);
  CHECK(plan.arena(a).counting());
  CHECK(plan.arena(a).array<int>(3).empty());
}

TEST_CASE("random plans: no two buffers of one time overlap, and no step's buffers are doubled") {
  std::mt19937 random(5);
  for (int round = 0; round < 300; ++round) {
    struct Life {
      std::size_t bytes, left;
      int from, to, last;
      std::size_t at(int step) const {
        return step < from ? 0 : step <= to ? bytes : step <= last ? left : 0;
      }
    };
    std::vector<Life> lives(1 + random() % MemoryPlan::kMostBuffers);
    MemoryPlan plan;
    for (Life& life : lives) {
      life.bytes = 64 * (random() % 50);
      life.from = static_cast<int>(random() % 8);
      life.to = life.from + static_cast<int>(random() % 4);
      life.left = random() % 3 == 0 ? life.bytes / 128 * 64 : 0;
      life.last = life.to + static_cast<int>(random() % 4);
      plan.add(life.bytes, life.from, life.to, life.left, life.last);
    }
    Arena counter;
    plan.place(counter);
    std::size_t most = 0, sum = 0;
    for (int step = 0; step < 16; ++step) {
      std::size_t alive = 0;
      for (const Life& life : lives) alive += life.at(step);
      most = std::max(most, alive);
    }
    for (std::size_t i = 0; i < lives.size(); ++i) {
      sum += lives[i].bytes;
      const std::size_t at = plan.offset(static_cast<std::int32_t>(i));
      CHECK(at + lives[i].bytes <= plan.bytes());
      for (std::size_t j = 0; j < i; ++j) {
        const std::size_t other = plan.offset(static_cast<std::int32_t>(j));
        for (int step = 0; step < 16; ++step) {
          const std::size_t mine = lives[i].at(step), others = lives[j].at(step);
          CHECK_FALSE((mine > 0 && others > 0 && at < other + others && other < at + mine));
        }
      }
    }
    CHECK(plan.bytes() >= most);
    CHECK(plan.bytes() <= sum);
  }
}
