// Times of ticks, and what is told of them.
#include <catch2/catch.hpp>

#include "recording/tick_times.hpp"

using namespace egofocus;
using namespace egofocus::recording;

TEST_CASE("percentiles by hand") {
  const Percentiles none = percentiles({});
  CHECK((none.p50 == 0 && none.p99 == 0 && none.max == 0));
  std::vector<double> falling;
  for (int i = 200; i > 0; --i) falling.push_back(i);
  const Percentiles p = percentiles(falling);
  CHECK(p.p50 == 101);
  CHECK(p.p99 == 199);
  CHECK(p.max == 200);
}

TEST_CASE("from event to depth: the newest event's age and the tick, of measured frames alone") {
  TickTimes times;
  DepthFrame frame;
  frame.age_us = 2500;
  frame.hypotheses = 32;
  times.add(frame, 10);
  frame.age_us = 5'000'000;  // carried
  frame.hypotheses = 0;
  times.add(frame, 4);
  CHECK(times.ticks() == 2);
  CHECK(times.tick_ms().max == 10);
  CHECK(times.event_to_depth_ms().max == 12.5);
  TickTimes more;
  more.add(times);
  more.add(times);
  CHECK(more.ticks() == 4);
  CHECK(more.event_to_depth_ms().p50 == 12.5);
}
