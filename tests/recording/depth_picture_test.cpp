#include "recording/depth_picture.hpp"

#include <catch2/catch.hpp>

using namespace egofocus;
using namespace egofocus::recording;

namespace {

double brightness(Rgb c) {
  return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
}

}  // namespace

TEST_CASE("brightness and warmth rise with nearness") {
  for (int i = 1; i < 256; ++i) {
    const Rgb before = depth_colour(static_cast<std::uint8_t>(i - 1));
    const Rgb now = depth_colour(static_cast<std::uint8_t>(i));
    CHECK(brightness(now) >= brightness(before));
    CHECK(now.r >= before.r);
  }
  CHECK(brightness(depth_colour(255)) > brightness(depth_colour(0)) + 180);
}

TEST_CASE("a depth picture shows near, far and unknown") {
  const std::uint16_t inverse[4] = {0, 500, 1000, 60000};
  const std::uint8_t confidence[4] = {9, 0, 200, 1};
  const RgbPicture picture = depth_picture(2, 2, inverse, confidence, 1000);
  CHECK(picture.at(0, 0) == depth_colour(0));
  CHECK(picture.at(1, 0) == Rgb{40, 40, 40});
  CHECK(picture.at(0, 1) == depth_colour(255));
  CHECK(picture.at(1, 1) == depth_colour(255));
}

TEST_CASE("the nearest inverse depth ignores the unknown and the farthest outliers") {
  std::vector<std::uint16_t> inverse(300, 100);
  std::vector<std::uint8_t> confidence(300, 1);
  inverse[7] = 65535;
  inverse[8] = 60000;
  inverse[9] = 50000;
  confidence[10] = 0;
  inverse[10] = 65535;
  CHECK(nearest_inverse_depth(inverse, confidence) == 50000);
  CHECK(nearest_inverse_depth({}, {}) == 1);
}

TEST_CASE("an event picture skips what lies outside") {
  std::vector<Event> events(3);
  events[0] = {0, 1, 0, 1};
  events[1] = {1, 0, 1, 0};
  events[2] = {2, 2, 0, 1};
  const RgbPicture picture = event_picture(2, 2, events);
  CHECK(picture.at(0, 0) == Rgb{255, 255, 255});
  CHECK(picture.at(1, 0).r > picture.at(1, 0).b);
  CHECK(picture.at(0, 1).b > picture.at(0, 1).r);
}
