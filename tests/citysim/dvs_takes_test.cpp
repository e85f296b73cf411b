// Takes of one sensor, and views that only some rows look at.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "dvs_support.hpp"

using namespace egofocus;
using namespace egofocus::citysim;
using namespace egofocus::citysim::test;

namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

std::vector<Event> shown(Dvs& dvs, std::int64_t t_us, double log_light) {
  Workers workers(2);
  const std::vector<float> light(std::size_t{kWidth} * kHeight, static_cast<float>(std::exp(log_light)));
  const LightView view{t_us, light};
  std::vector<Event> events;
  dvs.show({&view, 1}, workers, events);
  return events;
}

}  // namespace

TEST_CASE("a first take begins at its references; a later one stands anywhere between the thresholds") {
  DvsParameters p;
  p.threshold_on = 0.3;
  p.threshold_off = 0.2;
  constexpr double kPixels = kWidth * kHeight;
  Dvs dvs(kWidth, kHeight, p, 3);
  CHECK(shown(dvs, 1000, 0).empty());
  CHECK(shown(dvs, 2000, 0.29).empty());
  dvs.begin_take();
  // Earlier than the take before, and another light: neither is a step.
  CHECK(shown(dvs, 500, -1).empty());
  // References are evenly spread over 0.5: a step of 0.15 crosses the upper one of 30 % of the pixels, once.
  std::vector<Event> up = shown(dvs, 1500, -0.85);
  dvs.finish(up);
  CHECK(static_cast<double>(up.size()) / kPixels == Approx(0.3).margin(0.03));
  for (const Event& event : up) REQUIRE(event.polarity == 1);
  // They stand 0 to 0.15 above their new references now, the others at most 0.05 below theirs: back down by
  // 0.2 takes those 10 % alone across the lower one.
  std::vector<Event> down = shown(dvs, 2500, -1.05);
  dvs.finish(down);
  CHECK(static_cast<double>(down.size()) / kPixels == Approx(0.1).margin(0.02));
  for (const Event& event : down) REQUIRE(event.polarity == 0);
}

TEST_CASE("takes of one seed are the same, and the next take of a sensor is another one") {
  DvsParameters p;
  p.threshold_on = p.threshold_off = 0.3;
  const auto take = [](Dvs& dvs) {
    dvs.begin_take();
    std::vector<Event> events = shown(dvs, 0, 0);
    for (const Event& event : shown(dvs, 1000, 0.3)) events.push_back(event);
    dvs.finish(events);
    return events;
  };
  Dvs one(kWidth, kHeight, p, 3);
  Dvs two(kWidth, kHeight, p, 3);
  const std::vector<Event> first = take(one);
  CHECK(first.size() > 1000);
  CHECK(same(first, take(two)));
  CHECK_FALSE(same(first, take(one)));
}

TEST_CASE("rows that do not look at views on a straight way have the same events") {
  DvsParameters p;
  p.threshold_on = p.threshold_off = 0.11;
  // Each row brightens at its own rate; views are 1 ms apart, straight in log light.
  const auto ramp = [](int, int y, double t_us) { return std::exp((2.0 + y) * 1e-6 * t_us); };
  constexpr int kViews = 16;
  Workers workers(2);
  std::vector<std::vector<float>> light;
  for (int i = 0; i <= kViews; ++i) light.push_back(picture(kWidth, kHeight, ramp, 1000 * i));
  const auto events_with = [&](const std::vector<std::uint8_t>& bands) {
    std::vector<LightView> views;
    for (int i = 0; i <= kViews; ++i) views.push_back({1000 * i, light[static_cast<std::size_t>(i)], {}});
    for (int i = 1; i < kViews; ++i) views[static_cast<std::size_t>(i)].bands = bands;
    Dvs dvs(kWidth, kHeight, p, 3);
    std::vector<Event> events;
    dvs.show(views, workers, events);
    dvs.finish(events);
    return events;
  };
  const std::vector<Event> all = events_with({});
  const std::vector<Event> some = events_with({0, 1, 0, 1, 0, 0});
  REQUIRE(all.size() > 9000);
  REQUIRE(some.size() == all.size());
  std::int64_t worst_us = 0;
  std::size_t elsewhere = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    worst_us = std::max(worst_us, std::abs(all[i].t_us - some[i].t_us));
    elsewhere += all[i].y != some[i].y;
  }
  CHECK(worst_us <= 1);
  // A microsecond of rounding may change the order of two rows.
  CHECK(elsewhere < all.size() / 10);

  // Light that bends in between is missed by those that do not look, and by them alone.
  for (float& value : light[kViews / 2]) value *= 3;
  std::size_t looking[2] = {};
  for (const Event& event : events_with({0, 1, 0, 1, 0, 0})) ++looking[event.y / 8 % 2 == 1 && event.y < 32];
  std::size_t before[2] = {};
  for (const Event& event : all) ++before[event.y / 8 % 2 == 1 && event.y < 32];
  CHECK(looking[0] == before[0]);
  CHECK(looking[1] > before[1] + 10000);

  CHECK_THROWS_AS(events_with({0, 1}), std::invalid_argument);
}
