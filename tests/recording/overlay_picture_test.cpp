// The overlay's dots and lines at places that are known, and the events of overlapping stretches of time.
#include "recording/overlay_picture.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>
#include <string>

#include "hal/raw_header.hpp"
#include "recording/event_file.hpp"
#include "recording/event_mask.hpp"
#include "recording/event_reader.hpp"
#include "recording/mapped_file.hpp"
#include "recording/temporary_folder.hpp"

using namespace egofocus;
using namespace egofocus::recording;

namespace {

bool is_green(const Rgb& p) {
  return p.g > p.r && p.g > p.b;
}
bool is_red(const Rgb& p) {
  return p.r > p.g && p.r > p.b;
}
bool is_blue(const Rgb& p) {
  return p.b > p.g && p.b > p.r;
}

}  // namespace

TEST_CASE("an overlay: grey below, isolines between depths, events on top at their grid pixel") {
  // The grid begins two sensor pixels to the right: u = x - 2.
  Config config;
  config.camera.intrinsics = {10, 4, 10, 10, 4, 2};
  config.grid = {8, 4, 10, 10, 2, 2};
  const std::vector<std::int32_t> grid_pixel = grid_pixels(config);
  GreyPicture grey(8, 4, 100);
  grey.at(7, 0) = 255;
  Picture<float> depth(8, 4, 2.0f);
  for (std::int32_t y = 0; y < 4; ++y) {
    for (std::int32_t x = 4; x < 8; ++x) depth.at(x, y) = 4.0f;
    depth.at(7, y) = 0;  // unknown
  }
  for (std::int32_t x = 0; x < 8; ++x) depth.at(x, 0) = std::numeric_limits<float>::infinity();
  const std::vector<Event> events{{0, 3, 2, 1}, {1, 3, 2, 0}, {2, 6, 2, 1}, {3, 1, 1, 1}, {4, 40, 1, 1}};
  const RgbPicture picture = overlay_picture(config.grid, grey, depth, events, 10, grid_pixel);
  REQUIRE(picture.width_px == 8);
  CHECK(is_blue(picture.at(1, 2)));  // the later of two
  CHECK(is_red(picture.at(4, 2)));
  for (std::int32_t x = 0; x < 7; ++x) CHECK(is_green(picture.at(x, 0)));  // the sky's edge
  CHECK(is_green(picture.at(3, 1)));
  CHECK(is_green(picture.at(3, 3)));
  int coloured = 0;
  for (const Rgb& p : picture.pixels) coloured += p.r != p.g || p.g != p.b ? 1 : 0;
  CHECK(coloured == 1 + 1 + 7 + 3);
  CHECK(picture.at(7, 0).r > picture.at(0, 1).r);  // the ground is the grey picture
  const RgbPicture bare = overlay_picture(config.grid, {}, {}, {}, 10, grid_pixel);
  for (const Rgb& p : bare.pixels) CHECK(p == Rgb{255, 255, 255});
}

TEST_CASE("events of overlapping stretches of time") {
  const TemporaryFolder at;
  std::vector<Event> all;
  for (std::int64_t i = 0; i < 20000; ++i)
    all.push_back({i * 7, static_cast<std::uint16_t>(i % 64), static_cast<std::uint16_t>(i / 64 % 48), 1});
  EventFile file(at / "events.raw", {64, 48});
  file.write(all);
  file.close();
  const MappedFile raw(at / "events.raw");
  RawHeader header;
  REQUIRE(parse_raw_header(raw.bytes(), header).ok());
  EventReader reader(raw.bytes(), header);
  for (const auto& [first_us, last_us] : {std::pair<std::int64_t, std::int64_t>{-10, 6},
                                          {-10, 700},
                                          {0, 700},
                                          {350, 50'000},
                                          {49'999, 50'000},
                                          {100'000, 100'006},
                                          {100'006, 1 << 30}}) {
    std::vector<std::int64_t> expected;
    for (const Event& event : all) {
      if (event.t_us > first_us && event.t_us <= last_us) expected.push_back(event.t_us);
    }
    std::vector<std::int64_t> found;
    for (const Event& event : reader.between(first_us, last_us)) found.push_back(event.t_us);
    INFO(first_us << ".." << last_us);
    CHECK(found == expected);
  }
}
