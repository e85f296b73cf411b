#include "core/worker_pool.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace egofocus;

namespace {
struct Sums {
  std::vector<std::uint64_t> per_part = std::vector<std::uint64_t>(WorkerPool::kMaxParts, 0);
  std::uint64_t round = 0;
};
void add(void* context, int part, int parts) noexcept {
  auto& sums = *static_cast<Sums*>(context);
  for (std::uint64_t i = static_cast<std::uint64_t>(part); i < 100; i += static_cast<std::uint64_t>(parts))
    sums.per_part[static_cast<std::size_t>(part)] += i * sums.round;
}
}  // namespace

TEST_CASE("every part of every job runs exactly once, for any number of threads") {
  for (int parts = 1; parts <= 4; ++parts) {
    WorkerPool pool;
    REQUIRE(pool.start(parts, 0, -1).ok());
    CHECK(pool.parts() == parts);
    Sums sums;
    for (sums.round = 1; sums.round <= 500; ++sums.round) pool.run(add, &sums);
    std::uint64_t total = 0;
    for (auto s : sums.per_part) total += s;
    CHECK(total == 4950ull * (500 * 501 / 2));
    pool.stop();
  }
}

TEST_CASE("a pool can be stopped and started again; odd sizes are refused") {
  WorkerPool pool;
  CHECK(pool.start(0, 0, -1).code() == StatusCode::kBadThreads);
  CHECK(pool.start(9, 0, -1).code() == StatusCode::kBadThreads);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(pool.start(2, 0, -1).ok());
    CHECK(pool.start(2, 0, -1).code() == StatusCode::kBadState);
    Sums sums;
    sums.round = 1;
    pool.run(add, &sums);
    CHECK(sums.per_part[0] + sums.per_part[1] == 4950);
    pool.stop();
  }
}
