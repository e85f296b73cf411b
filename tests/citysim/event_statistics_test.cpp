#include "citysim/event_statistics.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "citysim/random.hpp"

using namespace egofocus;
using namespace egofocus::citysim;

namespace {

Event at(std::int64_t t_us, std::uint16_t x, std::uint16_t y, std::uint8_t polarity) {
  Event event;
  event.t_us = t_us;
  event.x = x;
  event.y = y;
  event.polarity = polarity;
  return event;
}

}  // namespace

TEST_CASE("statistics of a stream that was counted by hand") {
  // Pixel (2, 2): ON at 0, 1, 5 ms (a burst of three), OFF at 6 ms, OFF at 40 ms. Its neighbour (3, 3): ON at
  // 7 ms. Far away (8, 8): ON at 100 ms.
  const std::vector<Event> events = {at(0, 2, 2, 1),      at(1000, 2, 2, 1), at(5000, 2, 2, 1),
                                     at(6000, 2, 2, 0),   at(7000, 3, 3, 1), at(40'000, 2, 2, 0),
                                     at(100'000, 8, 8, 1)};
  const EventStatistics s = event_statistics(events, 10, 10);
  REQUIRE(s.events == 7);
  REQUIRE(s.duration_us == 100'000);
  REQUIRE(s.pixel_rate_hz == Approx(7 / 100.0 / 0.1));
  REQUIRE(s.active_share == Approx(0.03));
  REQUIRE(s.on_share == Approx(5 / 7.0));
  REQUIRE(s.peak_to_mean == Approx(5 / 0.6));  // 5 of the 6 in whole slices of 10 ms, and ten of these
  // Intervals: 1, 4, 1, 34 ms.
  REQUIRE(s.flip_share == Approx(0.25));
  REQUIRE(s.median_interval_us == 4000);
  REQUIRE(s.interval_share[5] == Approx(0.5));   // from 1,000
  REQUIRE(s.interval_share[6] == Approx(0.25));  // from 3,162
  REQUIRE(s.interval_share[8] == Approx(0.25));  // from 31,623
  // Bursts: 3, 1, 1 on (2, 2), 1 and 1 elsewhere.
  REQUIRE(s.burst_events == Approx(7 / 5.0));
  REQUIRE(s.burst_share[0] == Approx(0.8));
  REQUIRE(s.burst_share[2] == Approx(0.2));
  REQUIRE(s.median_burst_us == 5000);
  REQUIRE(s.median_gap_us == 4000);
  // Only (3, 3) has an event of a neighbour in the 10 ms before; the first four have it within 10 ms after.
  REQUIRE(s.unannounced_share == Approx(6 / 7.0));
  REQUIRE(s.isolated_share == Approx(2 / 7.0));
  REQUIRE(s.neighbours == Approx(1 / 7.0));
  REQUIRE(s.hot_pixel_share == 0);
}

TEST_CASE("all eight neighbours count, those across the sensor's rim do not") {
  std::vector<Event> events;
  for (std::uint16_t y = 0; y < 3; ++y) {
    for (std::uint16_t x = 0; x < 3; ++x) {
      if (x != 1 || y != 1) events.push_back(at(0, x, y, 1));
    }
  }
  events.push_back(at(100, 1, 1, 0));
  // Row by row, each event sees those before it: 0 1 1, 2 2, 1 3 2; the centre sees 8.
  REQUIRE(event_statistics(events, 3, 3).neighbours == Approx(20 / 9.0));
  const std::vector<Event> rim = {at(0, 4, 0, 1), at(1, 0, 1, 1), at(2, 4, 2, 1)};
  REQUIRE(event_statistics(rim, 5, 3).isolated_share == 1);
}

TEST_CASE("hot pixels and noise are found in a stream made of them") {
  sim::Random random(8);
  std::vector<Event> events;
  for (int i = 0; i < 30'000; ++i) {
    const bool hot = i % 3 == 0;  // ten pixels share a third of all events
    const std::uint32_t pixel = hot ? random.below(10) * 997 : random.below(10'000);
    events.push_back(at(i * 100, static_cast<std::uint16_t>(pixel % 100),
                        static_cast<std::uint16_t>(pixel / 100), random.chance(0.7)));
  }
  const EventStatistics s = event_statistics(events, 100, 100);
  REQUIRE(s.hot_pixel_share == Approx(10 / 10'000.0));
  REQUIRE(s.hot_event_share == Approx(1 / 3.0).epsilon(0.01));
  REQUIRE(s.on_share == Approx(0.7).epsilon(0.02));
  REQUIRE(s.flip_share == Approx(2 * 0.7 * 0.3).epsilon(0.03));
  REQUIRE(s.active_share == Approx(1 - std::exp(-2.0)).epsilon(0.02));
  // Of independent events: e^-(rate of 8 pixels x 10 ms), 0.0533 expected in 10 ms before; a hot one near by
  // makes it a little less.
  REQUIRE(s.unannounced_share == Approx(std::exp(-8 * 20'000 / 3.0 / 10'000 * 0.01)).epsilon(0.02));
  REQUIRE(s.isolated_share == Approx(std::exp(-16 * 20'000 / 3.0 / 10'000 * 0.01)).epsilon(0.03));
}

TEST_CASE("statistics of little or nothing, and of what may not be") {
  REQUIRE(event_statistics({}, 5, 5).events == 0);
  const std::vector<Event> one = {at(5, 1, 1, 1)};
  const EventStatistics s = event_statistics(one, 5, 5);
  REQUIRE(s.burst_events == 1);
  REQUIRE(s.isolated_share == 1);
  REQUIRE(s.pixel_rate_hz == 0);
  REQUIRE_THROWS_AS(event_statistics(one, 1, 5), std::invalid_argument);
  const std::vector<Event> backwards = {at(5, 1, 1, 1), at(4, 1, 1, 1)};
  REQUIRE_THROWS_AS(event_statistics(backwards, 5, 5), std::invalid_argument);
  // Times that lie decades apart take no time.
  const std::vector<Event> far = {at(0, 1, 1, 1), at(std::int64_t{1} << 55, 1, 1, 1)};
  REQUIRE(event_statistics(far, 5, 5).peak_to_mean > 1e6);
}
