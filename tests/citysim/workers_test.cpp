#include "citysim/workers.hpp"

#include <catch2/catch.hpp>
#include <stdexcept>
#include <vector>

using egofocus::citysim::Workers;

TEST_CASE("each index is worked on once, whatever the number of threads") {
  for (const int threads : {1, 2, 5}) {
    Workers workers(threads);
    REQUIRE(workers.threads() == threads);
    for (const int count : {0, 1, 7, 1000}) {
      std::vector<int> seen(static_cast<std::size_t>(count), 0);
      workers.for_each(count, [&](int i) { ++seen[static_cast<std::size_t>(i)]; });
      for (const int times : seen) REQUIRE(times == 1);
    }
  }
}

TEST_CASE("an exception of a body reaches the caller, and the workers go on") {
  Workers workers(3);
  REQUIRE_THROWS_AS(workers.for_each(10,
                                     [](int i) {
                                       if (i == 4) throw std::runtime_error("four");
                                     }),
                    std::runtime_error);
  int sum = 0;
  workers.for_each(1, [&](int) { ++sum; });
  REQUIRE(sum == 1);
}
