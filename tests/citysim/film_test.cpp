#include "citysim/film.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <tuple>

#include "small_worlds.hpp"

using namespace egofocus;
using namespace egofocus::citysim;

namespace {

std::vector<Event> film(const World& world, std::int64_t until_us, int threads = 1) {
  Workers workers(threads);
  const Optics optics(world.camera);
  Film camera(world, optics, workers, 7);
  std::vector<Event> events;
  camera.run_to(until_us, events);
  camera.finish(events);
  return events;
}

bool same(const std::vector<Event>& a, const std::vector<Event>& b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](const Event& x, const Event& y) {
           return std::tie(x.t_us, x.x, x.y, x.polarity) == std::tie(y.t_us, y.x, y.y, y.polarity);
         });
}

World room_world() {
  return make_world(Family::kRoom,
                    {.width_px = 173, .height_px = 130, .duration_s = 4, .library = test_library()}, 11);
}

}  // namespace

TEST_CASE("an edge gives each pixel its events, at the time when it passes, with the sign of its step") {
  // A dark plate before a bright wall, both blank, moves to the right at 1 m/s, 2 m away.
  World world = empty_world({0, 0, 0}, 2);
  world.camera.distortion = Distortion::kNone;
  Surface wall = {.texture = 0, .metres = 1e6, .colour = {1, 1, 1}};
  Surface plate = {.texture = 0, .metres = 1e6, .colour = {0.25f, 0.25f, 0.25f}};
  Mesh mesh;
  mesh.quad({5, 40, -40}, {5, -40, -40}, {5, -40, 40}, {5, 40, 40}, wall);
  world.scene.objects.push_back(mesh.take());
  mesh.quad({2, 2, -9}, {2, -0.2, -9}, {2, -0.2, 9}, {2, 2, 9}, plate);  // its right edge is at y = -0.2
  Object moving = mesh.take();
  moving.moves = true;
  moving.velocity_m_s = {0, -1, 0};
  moving.period_s = 100;
  world.scene.objects.push_back(moving);
  finish_scene(world.scene);
  world.sensor.threshold_on = 0.3;
  world.sensor.threshold_off = 0.3;
  const std::int64_t end_us = 1000000;
  std::map<int, std::vector<Event>> row;  // of one row, by column
  for (const Event& event : film(world, end_us)) {
    if (event.y == 60) row[event.x].push_back(event);
  }
  // From wall to plate: ln(1 / 4) = -1.386, four thresholds of 0.3 and no fifth; the edge passes pixel u when
  // f (0.2 + t) / 2 + cx = u.
  int checked = 0;
  double worst_us = 0;
  for (int u = 100; u < 150; ++u) {
    CAPTURE(u);
    const double t_us = 1e6 * ((u - world.camera.intrinsics.cx_px) * 2 / world.camera.intrinsics.fx_px - 0.2);
    if (t_us < 20000 || t_us > static_cast<double>(end_us) - 20000) continue;
    REQUIRE(row[u].size() == 4);
    for (const Event& event : row[u]) {
      CHECK(event.polarity == 0);
      worst_us = std::max(worst_us, std::abs(static_cast<double>(event.t_us) - t_us));
    }
    ++checked;
  }
  CHECK(checked > 30);
  // Views are no more than a pixel apart, and the light goes from the one to the other in between.
  CHECK(worst_us <= 1e6 * 2 / world.camera.intrinsics.fx_px);
}

TEST_CASE("views are close enough: nothing moves more than a pixel") {
  Workers workers(2);
  const World world = room_world();
  const Optics optics(world.camera);
  Film camera(world, optics, workers, 1);
  std::vector<Event> events;
  camera.run_to(2500000, events);
  CHECK(camera.counters().views > 100);
  CHECK(static_cast<double>(camera.counters().wide_steps) <=
        0.01 * static_cast<double>(camera.counters().views));
}

TEST_CASE("the same seed gives the same events for any number of threads; another seed others") {
  const World world = room_world();
  const std::vector<Event> one = film(world, 400000, 1);
  REQUIRE(one.size() > 1000);
  CHECK(same(one, film(world, 400000, 2)));
  CHECK(same(one, film(world, 400000, 5)));
  const World again = room_world();
  CHECK(same(one, film(again, 400000, 2)));
  const World other = make_world(
      Family::kRoom, {.width_px = 173, .height_px = 130, .duration_s = 4, .library = test_library()}, 12);
  CHECK_FALSE(same(one, film(other, 400000, 1)));
}

TEST_CASE("a film that is saved and gone on with has the same events") {
  const World world = room_world();
  Workers workers(2);
  const Optics optics(world.camera);
  std::vector<Event> whole;
  Film straight(world, optics, workers, 7);
  for (const std::int64_t t : {150000, 300000, 450000}) straight.run_to(t, whole);
  straight.finish(whole);

  std::vector<Event> pieces;
  Film first(world, optics, workers, 7);
  first.run_to(150000, pieces);
  first.run_to(300000, pieces);
  const std::vector<std::uint8_t> state = first.state();
  Film second(world, optics, workers, 7);
  second.restore(state);
  second.run_to(450000, pieces);
  second.finish(pieces);
  CHECK(same(whole, pieces));
  CHECK(second.counters().views == straight.counters().views);
  CHECK_THROWS_AS(second.restore(std::span(state).first(10)), std::invalid_argument);
}
