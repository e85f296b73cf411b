#include "core/elementary.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace egofocus;

TEST_CASE("elementary functions agree with libm") {
  for (int i = -4000; i <= 4000; ++i) {
    const double x = i * 0.0137;
    CHECK(std::abs(sine(x) - std::sin(x)) < 1e-13);
    CHECK(std::abs(cosine(x) - std::cos(x)) < 1e-13);
    CHECK(std::abs(arc_tangent(x) - std::atan(x)) < 1e-13);
    CHECK(std::abs(arc_tangent2(x, 0.3 - x) - std::atan2(x, 0.3 - x)) < 1e-13);
    CHECK(std::abs(exponential(x) / std::exp(x) - 1.0) < 1e-13);
    CHECK(floor_of(x) == std::floor(x));
    if (std::abs(std::cos(x)) > 1e-3)
      CHECK(std::abs(tangent(x) - std::tan(x)) < 1e-9 * (1.0 + std::abs(std::tan(x))));
  }
}

TEST_CASE("floor of whole numbers is the number itself") {
  for (double x : {-3.0, -1.0, 0.0, 1.0, 2.0, 4503599627370496.0}) CHECK(floor_of(x) == x);
}
