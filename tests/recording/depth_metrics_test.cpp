#include "recording/depth_metrics.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

using namespace egofocus::recording;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct PixelPair {
  double estimate;
  double truth;
};

Metrics metrics_of(const std::vector<PixelPair>& pixels, const MetricRange& range, double step_per_m) {
  MetricMeans terms;
  for (const PixelPair& pixel : pixels)
    terms.add(pixel_terms(pixel.estimate, pixel.truth, range, step_per_m));
  return image_metrics(terms);
}

}  // namespace

TEST_CASE("every metric of four pixels, counted by hand") {
  // 4.5 for 4 m; 12 for 16 m; no estimate for 25 m (80 m, in the paper's way 0); 90 for 48 m (80 m, or 90).
  const Metrics m = metrics_of({{4.5, 4}, {12, 16}, {0, 25}, {90, 48}}, {}, 0.01);
  CHECK(m[kAbsRel] == Approx((0.125 + 0.25 + 2.2 + 2.0 / 3) / 4));
  CHECK(m[kSqRel] == Approx((0.0625 + 1 + 121 + 64.0 / 3) / 4));
  CHECK(m[kRmse] == Approx(std::sqrt((0.25 + 16 + 3025 + 1024) / 4)));
  CHECK(m[kRmseLog] == Approx(std::sqrt((std::pow(std::log(9.0 / 8), 2) + std::pow(std::log(3.0 / 4), 2) +
                                         std::pow(std::log(16.0 / 5), 2) + std::pow(std::log(5.0 / 3), 2)) /
                                        4)));
  CHECK(m[kD1] == 0.25);
  CHECK(m[kD2] == 0.5);   // 4/3 < 1.5625 < 5/3
  CHECK(m[kD3] == 0.75);  // 5/3 < 1.953 < 3.2
  CHECK(m[kEpe] == Approx((0.5 + 4 + 55 + 32) / 4));
  CHECK(m[kMae10m] == Approx(0.5));
  CHECK(m[kMae20m] == Approx(2.25));
  CHECK(m[kMae30m] == Approx(59.5 / 3));
  CHECK(m[kIndexMae] == Approx((100.0 / 36 + 100.0 / 48 + 2.75 + 100.0 / 120) / 4));

  CHECK(m[kPaperAbsRel] == Approx((0.125 + 0.25 + 1 + 0.875) / 4));
  CHECK(m[kPaperSqRel] == Approx((0.015625 + 0.0625 + 1 + 0.765625) / 4));
  CHECK(m[kPaperRmse] == Approx(std::sqrt((0.25 + 16 + 625 + 1764) / 4)));
  CHECK(m[kPaperRmseLog] ==
        Approx(std::sqrt((std::pow(std::log(9.0 / 8), 2) + std::pow(std::log(3.0 / 4), 2) +
                          std::pow(std::log(15.0 / 8), 2)) /
                         3)));
  CHECK(m[kPaperD1] == 0.25);
  CHECK(m[kPaperD2] == 0.5);
  CHECK(m[kPaperD3] == 0.75);
  CHECK(m[kPaperEpe] == Approx((0.5 + 4 + 25 + 42) / 4));
  CHECK(m[kPaperMae10m] == Approx(0.5));
  CHECK(m[kPaperMae20m] == Approx(2.25));
  CHECK(m[kPaperMae30m] == Approx(29.5 / 3));
  CHECK(m[kPaperZeroShare] == 0.25);
}

TEST_CASE("the range clips estimates, never truth") {
  const MetricRange range{50, 1, 20};
  CHECK_FALSE(range.is_truth(0));
  CHECK(range.is_truth(50));
  CHECK_FALSE(range.is_truth(50.001));
  CHECK_FALSE(range.is_truth(kInfinity));
  CHECK(metrics_of({{0.1, 0.5}}, range, 0)[kAbsRel] == Approx(1.0));         // 1 m
  CHECK(metrics_of({{kInfinity, 40}}, range, 0)[kAbsRel] == Approx(0.5));    // 20 m
  CHECK(metrics_of({{0, 40}}, range, 0)[kAbsRel] == Approx(0.5));            // no estimate: infinity
  CHECK(metrics_of({{0.1, 0.5}}, range, 0)[kPaperAbsRel] == Approx(0.8));    // not clipped
  CHECK(metrics_of({{100, 40}}, range, 0)[kPaperAbsRel] == Approx(1.5));     // 100 m is not above 100 m
  CHECK(metrics_of({{100.01, 40}}, range, 0)[kPaperAbsRel] == Approx(1.0));  // 0
  CHECK(metrics_of({{1.25 * 8, 8}}, range, 0)[kD1] == 0);                    // 1.25 is not below 1.25
}

TEST_CASE("what an image lacks is not counted as zero") {
  const Metrics far = metrics_of({{0, 40}}, {}, 0);
  CHECK(std::isnan(far[kMae10m]));
  CHECK(std::isnan(far[kMae30m]));
  CHECK(std::isnan(far[kIndexMae]));
  CHECK(std::isnan(far[kPaperRmseLog]));
  CHECK(far[kRmse] == Approx(40));

  MetricMeans images;
  CHECK(std::isnan(images.mean()[kAbsRel]));
  images.add(far);
  images.add(metrics_of({{3, 2}}, {}, 0.1));
  CHECK(images.count() == 2);
  CHECK(images.mean()[kMae10m] == Approx(1));   // of the one image that has it
  CHECK(images.mean()[kRmse] == Approx(20.5));  // the mean of roots, not the root of a mean
  MetricMeans more;
  more.add(metrics_of({{5, 2}}, {}, 0.1));
  more.add(images);
  CHECK(more.count() == 3);
  CHECK(more.mean()[kMae10m] == Approx(2));
}
