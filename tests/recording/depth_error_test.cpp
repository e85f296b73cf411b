#include "recording/depth_error.hpp"

#include <catch2/catch.hpp>

using namespace egofocus::recording;

TEST_CASE("error metrics of a map counted by hand") {
  //                       no truth  unknown  exact  +10 %  +50 %  far (clipped to 80)  beyond 80
  const float truth[] = {0.0f, 2.0f, 4.0f, 10.0f, 2.0f, 64.0f, 81.0f};
  const float estimate[] = {1.0f, 0.0f, 4.0f, 11.0f, 3.0f, 500.0f, 80.0f};
  const DepthError error = depth_error(estimate, truth);
  CHECK(error.truth_px == 5);
  CHECK(error.compared_px == 4);
  CHECK(error.coverage == Approx(0.8));
  CHECK(error.median == Approx(0.25));  // of 0, 0.1, 0.25, 0.5 the upper middle
  CHECK(error.abs_rel == Approx((0.0 + 0.1 + 0.25 + 0.5) / 4));
  CHECK(error.within_10_percent == Approx(0.5));
  CHECK(error.d1 == Approx(0.5));  // 80 / 64 = 1.25 is not below 1.25

  const std::uint8_t mask[] = {1, 0, 1, 0, 0, 0, 0};
  CHECK(depth_error(estimate, truth, mask).truth_px == 1);
  CHECK(depth_error(estimate, truth, mask).median == 0.0);
  CHECK(depth_error({}, {}).coverage == 0.0);
}
