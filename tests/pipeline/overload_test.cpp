// More events than the configuration allows: which stay, that they are the same each time, and that each is
// counted.
#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "core/event_thinner.hpp"
#include "support/engine_in_block.hpp"
#include "support/frame_hash.hpp"
#include "support/sliding_scene.hpp"

using namespace egofocus;
using test::EngineInBlock;
using test::SlidingScene;

namespace {

// Numbers of those that stay, of `per_ms` events evenly spread in each millisecond.
std::vector<int> kept_of(EventThinner& thinner, std::int64_t slot, int per_ms) {
  std::vector<int> kept;
  for (int i = 0; i < per_ms; ++i)
    if (thinner.keep(slot * 1000 + i * 1000 / per_ms)) kept.push_back(i);
  return kept;
}

// Each event of the scene `times` over, in pieces of `piece_us`.
struct Flood {
  SlidingScene scene;
  int times = 1;
  std::int64_t piece_us = 7'000;
  std::int64_t at_us = 0;
  std::uint64_t pushed = 0;

  Source source() {
    Source s;
    s.self = this;
    s.poll = [](void* self, Inlets& inlets, std::int64_t until_us, std::int64_t) noexcept {
      return static_cast<Flood*>(self)->poll(inlets, until_us);
    };
    return s;
  }

  Delivery poll(Inlets& inlets, std::int64_t until_us) noexcept {
    const std::int64_t to_us = std::min({until_us, at_us + piece_us, std::int64_t{500'000}});
    std::vector<Event> events;
    for (const Event& event : scene.events(at_us, to_us))
      events.insert(events.end(), static_cast<std::size_t>(times), event);
    pushed += inlets.push(events);
    inlets.push(SlidingScene::poses(at_us, to_us));
    at_us = to_us;
    return {at_us, at_us >= 500'000, {}};
  }
};

struct Outcome {
  std::uint64_t hash = 0;
  std::uint32_t flags_of_all = 0;
  Health health;
  std::uint64_t pushed = 0;
};

Outcome run(int times, std::int64_t piece_us, std::int32_t max_event_rate_hz) {
  Config config = SlidingScene::config();
  config.rings.max_event_rate_hz = max_event_rate_hz;
  Flood flood;
  flood.times = times;
  flood.piece_us = piece_us;
  EngineInBlock engine(config);
  REQUIRE(engine->attach(flood.source()).ok());
  REQUIRE(engine->start(ClockKind::kVirtual, 50'000).ok());
  test::FrameHash hash;
  Outcome outcome;
  outcome.flags_of_all = ~0u;
  for (DepthFrame frame; engine->tick() && engine->newest(frame);) {
    hash.add(frame);
    outcome.flags_of_all &= frame.flags;
  }
  outcome.hash = hash.value();
  outcome.health = engine->health();
  outcome.pushed = flood.pushed;
  return outcome;
}

}  // namespace

TEST_CASE("a steady overload is thinned evenly, to the budget and not below") {
  for (const int times : {2, 5, 50}) {
    EventThinner thinner(100'000);
    CHECK(kept_of(thinner, 7, 100 * times).size() == 100);  // the first slot is cut off
    for (std::int64_t slot = 8; slot < 60; ++slot) {
      const std::vector<int> kept = kept_of(thinner, slot, 100 * times);
      REQUIRE(kept.size() == 100);
      for (std::size_t i = 0; i < kept.size(); ++i) REQUIRE(kept[i] == static_cast<int>(i) * times);
    }
  }
}

TEST_CASE("whatever the load does, no slot is above its budget, and without overload all stay") {
  EventThinner thinner(50'000);
  std::int64_t slot = 0;
  int before = 0;
  for (const int load : {10, 50, 51, 75, 1000, 3, 0, 50, 400, 400, 49}) {
    const auto kept = static_cast<int>(kept_of(thinner, slot++, load).size());
    CHECK(kept <= 50);
    if (before <= 50) CHECK(kept == std::min(load, 50));
    CHECK(kept >= std::min(load, 50) / ((before + 49) / 50 + 1));
    before = load;
  }
}

TEST_CASE("after a pause a slot starts anew, and times that go back break nothing") {
  EventThinner thinner(10'000);
  CHECK(kept_of(thinner, 3, 100).size() == 10);
  CHECK(kept_of(thinner, 5, 8).size() == 8);  // slot 4 was empty
  CHECK(kept_of(thinner, 2, 8).size() == 8);
  CHECK(thinner.keep(INT64_MIN / 4));
  CHECK(thinner.keep(INT64_MAX));
}

TEST_CASE(
    "five times the events: the same depth however they are cut into pieces, all counted, frames flagged") {
  const Outcome whole = run(5, 50'000, 10'000);
  for (const std::int64_t piece_us : {std::int64_t{7'000}, std::int64_t{333}}) {
    const Outcome cut = run(5, piece_us, 10'000);
    CHECK(cut.hash == whole.hash);
    CHECK(cut.health.events.over_rate == whole.health.events.over_rate);
  }
  const EventCounters& events = whole.health.events;
  CHECK(events.in == whole.pushed);
  CHECK(events.in == 25'000);
  CHECK(events.kept + events.over_rate == 25'000);
  CHECK(events.kept >= 5'000);
  CHECK(events.kept <= 10 * 501);  // the last slot has only begun
  CHECK(events.ring_dropped == 0);
  CHECK((whole.flags_of_all & kOverload) != 0);
}

TEST_CASE("a limit that is not reached changes no byte") {
  const Outcome plain = run(1, 7'000, 0);
  const Outcome limited = run(1, 7'000, 10'000);
  CHECK((plain.flags_of_all & kOverload) == 0);
  CHECK(limited.health.events.over_rate == 0);
  CHECK(limited.hash == plain.hash);
}
