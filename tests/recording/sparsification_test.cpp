#include "recording/sparsification.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace egofocus::recording;

namespace {

/// Errors 1 .. 20; the confidence as asked for.
template <typename Confidence>
std::vector<JudgedPixel> twenty(Confidence confidence) {
  std::vector<JudgedPixel> pixels;
  for (int error = 1; error <= 20; ++error)
    pixels.push_back({static_cast<double>(error), static_cast<std::uint8_t>(confidence(error))});
  return pixels;
}

}  // namespace

TEST_CASE("a confidence that knows the errors is the oracle") {
  const Sparsification s = sparsification(twenty([](int error) { return 200 - error; }));
  for (std::size_t k = 0; k < 20; ++k) {
    CAPTURE(k);
    CHECK(s.by_oracle[k] == Approx((21.0 - static_cast<double>(k)) / 2));
    CHECK(s.by_confidence[k] == Approx(s.by_oracle[k]));
  }
  CHECK(area_under(s.by_oracle) == Approx(19 * (10.5 + 1.0) / 2 / 20));
}

TEST_CASE("a constant confidence gains nothing, a wrong one loses") {
  const Sparsification flat = sparsification(twenty([](int) { return 7; }));
  for (const double value : flat.by_confidence) CHECK(value == Approx(10.5));
  CHECK(area_under(flat.by_confidence) == Approx(10.5 * 0.95));
  const Sparsification wrong = sparsification(twenty([](int error) { return error; }));
  CHECK(wrong.by_confidence[19] == Approx(20));
}

TEST_CASE("pixels of equal confidence count with their mean") {
  // 10 sure pixels with errors 1..10, 10 unsure with 11..20.
  const Sparsification s = sparsification(twenty([](int error) { return error <= 10 ? 2 : 1; }));
  CHECK(s.by_confidence[10] == Approx(5.5));
  CHECK(s.by_confidence[15] == Approx(5.5));
  CHECK(s.by_confidence[5] == Approx((10 * 5.5 + 5 * 15.5) / 15));
  const std::vector<JudgedPixel> one{{3.0, 9}};
  CHECK(sparsification(one).by_confidence[19] == 3.0);
}

TEST_CASE("curves of images are averaged") {
  SparsificationMeans means;
  CHECK(means.mean().by_confidence[0] == 0);
  means.add(sparsification(twenty([](int) { return 1; })));
  SparsificationMeans other;
  other.add(sparsification(std::vector<JudgedPixel>{{0.5, 1}}));
  means.add(other);
  CHECK(means.images() == 2);
  CHECK(means.mean().by_confidence[3] == Approx((10.5 + 0.5) / 2));
  CHECK(means.mean().by_oracle[19] == Approx((1.0 + 0.5) / 2));
}
