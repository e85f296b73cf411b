// Depth seen from another place, against planes and boxes whose depth along a ray is written down.
#include "pipeline/depth_reprojection.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "support/askew_scene.hpp"

using namespace egofocus;
using namespace egofocus::test;

namespace {

Map moved(const Map& from, const Camera& to, double max_travel = 1, std::uint32_t share_q8 = 256) {
  Map out;
  std::vector<std::uint32_t> landed(kPixels, 0xa5a5a5a5u);
  const std::size_t known =
      reproject(reprojection(to.from_first(), kGrid, kScale_per_m, max_travel), kGrid, share_q8,
                from.inverse_depth, from.confidence, landed, out.inverse_depth, out.confidence);
  CHECK(known == out.known());
  return out;
}

/// In steps of the scale, within the picture: the values that the scene has inside the pixel's surroundings
/// of `slack_px`.
bool plausible(const Scene& scene, const Camera& camera, std::int32_t x, std::int32_t y, double value,
               double slack_px) {
  double least = 1e9;
  double most = 0;
  for (int j = -4; j <= 4; ++j) {
    for (int i = -4; i <= 4; ++i) {
      const double rho = scene.rho(camera, x + i * slack_px / 4, y + j * slack_px / 4) / kScale_per_m;
      least = std::min(least, rho);
      most = std::max(most, rho);
    }
  }
  return value >= least - 1 && value <= most + 1;
}

/// Whether the first camera, at the origin, sees what the other one sees at (u, v): inside its picture, with
/// `border_px` to spare.
bool was_in_picture(const Scene& scene, const Camera& camera, double u, double v, double border_px) {
  const Vector d = camera.ray(u, v);
  const double t = 1 / scene.rho(camera, u, v);
  const Vector p{camera.centre.x + t * d.x, camera.centre.y + t * d.y, camera.centre.z + t * d.z};
  const double x = kGrid.fx_px * p.x / p.z + kGrid.cx_px;
  const double y = kGrid.fy_px * p.y / p.z + kGrid.cy_px;
  return p.z > 0 && x > border_px && x < kGrid.width_px - 1 - border_px && y > border_px &&
         y < kGrid.height_px - 1 - border_px;
}

}  // namespace

TEST_CASE("a camera that stands still sees the very same bytes, holes included") {
  Map map = seen({true}, {});
  std::mt19937 random(5);
  for (std::size_t i = 0; i < kPixels; ++i) {
    map.confidence[i] = static_cast<std::uint8_t>(random() & 255);
    map.inverse_depth[i] = static_cast<std::uint16_t>(map.confidence[i] != 0 ? random() : 0);
  }
  map.confidence[500] = 9;
  map.inverse_depth[500] = 65535;
  const Map out = moved(map, {});
  CHECK(out.inverse_depth == map.inverse_depth);
  CHECK(out.confidence == map.confidence);
}

TEST_CASE("a landing is that of the formula in doubles") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> part(-1, 1);
  int landings = 0;
  for (int i = 0; i < 20'000; ++i) {
    Camera to = Camera::turned(part(random), part(random), 2 * part(random));
    to.centre = {part(random), part(random), part(random)};
    const auto x = static_cast<std::int32_t>(random() % 96);
    const auto y = static_cast<std::int32_t>(random() % 72);
    const auto index = static_cast<std::uint16_t>(i % 7 == 0 ? 0 : random() % 6000);
    const double rho = index * kScale_per_m;
    // The point at depth 1 / rho, times rho.
    const double from[3] = {(x - kGrid.cx_px) / kGrid.fx_px - rho * to.centre.x,
                            (y - kGrid.cy_px) / kGrid.fy_px - rho * to.centre.y, 1 - rho * to.centre.z};
    double p[3];
    for (int row = 0; row < 3; ++row)
      p[row] = to.axes[row][0] * from[0] + to.axes[row][1] * from[1] + to.axes[row][2] * from[2];
    const double u = kGrid.fx_px * p[0] / p[2] + kGrid.cx_px;
    const double v = kGrid.fy_px * p[1] / p[2] + kGrid.cy_px;
    const Vector& c = to.centre;
    const double travel = rho * std::sqrt(c.x * c.x + c.y * c.y + c.z * c.z);
    Landing out;
    const bool lands = land(reprojection(to.from_first(), kGrid, kScale_per_m, 1), kGrid, x, y, index, out);
    const double edge = std::min({p[2] - 0.0625, u + 1, 96 - u, v + 1, 72 - v, 2 - travel});
    if (std::abs(edge) < 1e-2) continue;  // decided by the last bit
    INFO("u " << u << " v " << v << " depth " << p[2] << " travel " << travel);
    REQUIRE(lands == (edge > 0));
    if (!lands) continue;
    ++landings;
    CHECK(std::abs(out.u_q16 / 65536.0 - u) < 0.002);
    CHECK(std::abs(out.v_q16 / 65536.0 - v) < 0.002);
    CHECK(std::abs(out.inverse_depth - std::min(65535.0, index / p[2])) <= 0.501);
    CHECK(std::abs(out.travel_q8 / 256.0 - travel) < 0.006);
  }
  CHECK(landings > 2000);
}

TEST_CASE("after a turn every pixel that was in the picture has its depth, and no other") {
  for (const bool has_box : {false, true}) {
    const Scene scene{has_box};
    for (const auto& angles :
         {std::array<double, 3>{0.2, 0, 0}, {-0.1, 0.15, 0}, {0, 0, 0.5}, {0.12, -0.1, -1.2}}) {
      const Camera to = Camera::turned(angles[0], angles[1], angles[2]);
      const Map out = moved(seen(scene, {}), to);
      int wrong = 0;
      std::size_t beyond_1px = 0;
      int missing = 0;
      int invented = 0;
      for (std::int32_t y = 0; y < kGrid.height_px; ++y) {
        for (std::int32_t x = 0; x < kGrid.width_px; ++x) {
          const auto at = static_cast<std::size_t>(y * kGrid.width_px + x);
          const bool known = out.confidence[at] != 0;
          missing += !known && was_in_picture(scene, to, x, y, 1) ? 1 : 0;
          invented += known && !was_in_picture(scene, to, x, y, -2) ? 1 : 0;
          // What falls on a pixel lies within half of one; what fills a hole comes from the next pixel.
          beyond_1px += known && !plausible(scene, to, x, y, out.inverse_depth[at], 1) ? 1 : 0;
          wrong += known && !plausible(scene, to, x, y, out.inverse_depth[at], 1.75) ? 1 : 0;
        }
      }
      INFO("yaw " << angles[0] << " pitch " << angles[1] << " roll " << angles[2] << " box " << has_box);
      CHECK(out.known() > kPixels / 2);
      CHECK(missing == 0);
      CHECK(invented == 0);
      CHECK(wrong == 0);
      CHECK(beyond_1px < out.known() / 200);
    }
  }
}

TEST_CASE(
    "after a step towards a box: its front without cracks, the wall around it, nothing where nobody looked") {
  const Scene scene{true};
  Camera to;
  SECTION("ahead") {
    to.centre = {0, 0, 0.4};
  }
  SECTION("ahead and aside") {
    to.centre = {0.12, -0.05, 0.3};
  }
  SECTION("back, with a turn") {
    to = Camera::turned(0.05, 0, 0.1);
    to.centre = {0, 0.05, -0.3};
  }
  const Map out = moved(seen(scene, {}), to);
  int box_px = 0;
  int box_wrong = 0;
  int hidden_px = 0;
  int wall_wrong = 0;
  int invented = 0;
  for (std::int32_t y = 0; y < kGrid.height_px; ++y) {
    for (std::int32_t x = 0; x < kGrid.width_px; ++x) {
      const auto at = static_cast<std::size_t>(y * kGrid.width_px + x);
      const bool known = out.confidence[at] != 0;
      invented += known && !was_in_picture(scene, to, x, y, -2.5) ? 1 : 0;
      // Away from its edges the box must be whole and nothing else may shine through.
      const auto box = [&](double u, double v) { return scene.on_box(to.centre, to.ray(u, v)); };
      const bool inside = box(x - 2, y - 2) && box(x + 2, y - 2) && box(x - 2, y + 2) && box(x + 2, y + 2);
      const bool outside = !box(x - 3, y - 3) && !box(x + 3, y - 3) && !box(x - 3, y + 3) &&
                           !box(x + 3, y + 3) && !box(x, y - 3) && !box(x, y + 3) && !box(x - 3, y) &&
                           !box(x + 3, y);
      if (inside && was_in_picture(scene, to, x, y, 2)) {
        ++box_px;
        box_wrong += !known || !plausible(scene, to, x, y, out.inverse_depth[at], 1.5) ? 1 : 0;
      } else if (outside) {
        // The wall: seen, or hidden by the box when it was measured.
        hidden_px += !known && was_in_picture(scene, to, x, y, 2) ? 1 : 0;
        wall_wrong += known && !plausible(scene, to, x, y, out.inverse_depth[at], 2) ? 1 : 0;
      }
    }
  }
  CHECK(box_px > 400);
  CHECK(box_wrong == 0);
  CHECK(wall_wrong == 0);
  CHECK(invented == 0);
  CHECK(hidden_px < 250);
}

TEST_CASE("what the box hid when it was measured stays without depth, however it is uncovered") {
  const Scene scene{true};
  Camera to;
  to.centre = {0.3, 0, 0};
  const Map out = moved(seen(scene, {}), to);
  // The box's left and right edges lie at x = -0.3 and 0.25: its shadow on the wall, seen from the first
  // camera, is uncovered to its right by f * 0.3 * (1 / 1.5 - 1 / 4) = 10 px.
  const auto box_edge = static_cast<std::int32_t>(kGrid.fx_px * (0.25 - 0.3) / 1.5 + kGrid.cx_px);
  int empty = 0;
  for (std::int32_t x = box_edge; x < box_edge + 14; ++x) {
    const auto at = static_cast<std::size_t>(40 * kGrid.width_px + x);
    empty += out.confidence[at] == 0 ? 1 : 0;
    if (out.confidence[at] != 0) CHECK(plausible(scene, to, x, 40, out.inverse_depth[at], 1.5));
  }
  CHECK(empty >= 8);
  CHECK(empty <= 12);
}

TEST_CASE("the nearest wins, whatever the order; of equals the more confident") {
  for (const int first : {30, 34}) {
    Map map;
    // Slid to the right by 1 m at f = 80: inverse depths of 2/80 and 6/80 move left by 2 and 6 px.
    map.set(30, 10, 2.0 / 80, 50);
    map.set(34, 10, 6.0 / 80, 60);
    map.set(first == 30 ? 30 : 34, 20, 2.0 / 80, first == 30 ? 7 : 9);
    Camera to;
    to.centre = {1, 0, 0};
    const Map out = moved(map, to);
    const auto at = static_cast<std::size_t>(10 * kGrid.width_px + 28);
    CHECK(out.inverse_depth[at] == std::lround(6.0 / 80 / kScale_per_m));
    CHECK(out.confidence[at] == Approx(60 * (1 - 6.0 / 80)).margin(1));
    CHECK(out.known() == 2);
  }
  // Two that fall on one pixel from the same depth: turned away, the picture's rim shrinks.
  Map map;
  for (std::int32_t x = 0; x < 96; ++x)
    map.set(x, 30, 0.25, static_cast<std::uint8_t>(x % 2 != 0 ? 200 : 40));
  Camera back;
  back.centre = {0, 0, -4};  // half the size
  const Map out = moved(map, back, 1);
  CHECK(out.known() == 0);  // a way as long as the depth: no estimate is left
  back.centre = {0, 0, -2};
  const Map half = moved(map, back, 1);
  const auto row = half.confidence.begin() + 32 * 96;
  CHECK(std::count_if(row, row + 96, [](std::uint8_t c) { return c != 0; }) >= 60);
  int weak = 0;
  for (std::int32_t x = 20; x < 76; ++x) weak += row[x] != 0 && row[x] < 50 ? 1 : 0;
  CHECK(weak < 56 / 2);  // two of three land together: the surer one is what is left there
}

TEST_CASE("confidence: times the share, times what the way leaves, never rounded to nothing") {
  Map map;
  for (std::int32_t x = 0; x < 96; ++x)
    map.set(x, 30, x / 96.0, static_cast<std::uint8_t>(x == 50 ? 1 : 200));
  Camera to;
  to.centre = {0, 0.02, 0};  // less than half a pixel for rho < 0.3, and a few pixels down at most
  const double max_travel = 0.01;
  Map still = moved(map, {}, max_travel, 128);
  for (std::size_t x = 0; x < 96; ++x) {
    const std::uint8_t old = map.confidence[30 * 96 + x];
    CHECK(still.confidence[30 * 96 + x] == (old + 1) / 2);
  }
  const Map out = moved(map, to, max_travel);
  for (std::size_t x = 0; x < 30; ++x) {
    const double left = 1 - static_cast<double>(x) / 96 * 0.02 / max_travel;
    CHECK(out.confidence[30 * 96 + x] == Approx(200 * left).margin(1.6));
  }
  // Inverse depths above 1/2 are nearer than 2 m, the way over the limit.
  for (std::size_t i = 0; i < kPixels; ++i) {
    if (out.confidence[i] != 0) CHECK(out.inverse_depth[i] * kScale_per_m < 0.502);
  }
}

TEST_CASE("what is too near for an estimate hides what is behind it, and its place stays empty") {
  Map map;
  for (std::int32_t y = 0; y < 72; ++y) {
    for (std::int32_t x = 0; x < 96; ++x) map.set(x, y, x >= 40 && x < 60 ? 0.9 : 0.05);
  }
  Camera to;
  to.centre = {0.1, 0, 0};
  const Map out = moved(map, to, 0.08);
  // 0.9 * 0.1 is over the limit of 0.08: moved left by 0.9 * 0.1 * 80 = 7 px, without an estimate.
  for (std::int32_t x = 34; x < 52; ++x) CHECK(out.confidence[static_cast<std::size_t>(36 * 96 + x)] == 0);
  CHECK(out.confidence[36 * 96 + 30] != 0);
  CHECK(out.confidence[36 * 96 + 62] != 0);
}

TEST_CASE(
    "holes up to 3 px between two painted pixels get the farther side; wider ones, and open ones, none") {
  for (const std::int32_t gap : {1, 2, 3, 4}) {
    Map map;
    for (std::int32_t x = 20; x < 40; ++x) map.set(x, 12, 0.2, 100);
    for (std::int32_t x = 40; x < 60; ++x) map.set(x, 12, 0.1, 80);
    Camera to;
    to.centre = {0.125 * gap, 0, 0};  // 2 gap px and 1 gap px: a hole of gap px
    const Map out = moved(map, to, 1);
    const std::int32_t hole = 40 - 2 * gap;
    for (std::int32_t x = hole; x < hole + gap; ++x) {
      const auto at = static_cast<std::size_t>(12 * 96 + x);
      INFO("gap " << gap << " x " << x);
      if (gap <= 3) {
        CHECK(out.inverse_depth[at] == std::lround(0.1 / kScale_per_m));
        CHECK(out.confidence[at] == Approx(80 * (1 - 0.1 * 0.125 * gap)).margin(1.6));
      } else {
        CHECK(out.confidence[at] == 0);
      }
    }
    CHECK(out.confidence[static_cast<std::size_t>(12 * 96 + 59 - gap + 1)] == 0);
    CHECK(out.confidence[static_cast<std::size_t>(13 * 96 + 30)] == 0);  // a row beside it is open
  }
}

TEST_CASE("motions without measure: nothing is drawn, nothing breaks") {
  const Map map = seen({true}, {});
  Camera to;
  to.centre = {1e8, -1e8, 1e8};
  CHECK(moved(map, to).known() == 0);
  CHECK(moved(map, Camera::turned(3.1, 0, 0)).known() == 0);
  CHECK(moved(map, Camera::turned(0, 1.5, 0)).known() == 0);
  Map far;
  for (std::uint8_t& c : far.confidence) c = 1;
  CHECK(moved(far, to).known() == kPixels);  // infinity does not move
}
