// Attached sources, by script, under both clocks.
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "core/clock.hpp"
#include "support/engine_in_block.hpp"
#include "support/frame_hash.hpp"
#include "support/sliding_scene.hpp"

using namespace egofocus;
using test::EngineInBlock;
using test::SlidingScene;

namespace {

// A recording of the scene, delivered in pieces of at most `piece_us`; ends at `end_us`.
struct SceneSource {
  SlidingScene scene;
  std::int64_t end_us = 0;
  std::int64_t piece_us = 7'000;
  std::int64_t at_us = 0;
  bool poses = true;
  int polls = 0;

  Source source() {
    Source s;
    s.self = this;
    s.name = "scene";
    s.poll = [](void* self, Inlets& inlets, std::int64_t until_us, std::int64_t) noexcept {
      return static_cast<SceneSource*>(self)->poll(inlets, until_us);
    };
    return s;
  }

  Delivery poll(Inlets& inlets, std::int64_t until_us) noexcept {
    ++polls;
    const std::int64_t to_us = std::min({until_us, at_us + piece_us, end_us});
    const std::vector<Event> events = scene.events(at_us, to_us);
    if (inlets.event_room() >= events.size()) {  // else: come again
      inlets.push(events);
      if (poses) inlets.push(SlidingScene::poses(at_us, to_us));
      at_us = to_us;
    }
    return {at_us, at_us >= end_us, {}};
  }
};

Delivery idle(void* self, Inlets&, std::int64_t, std::int64_t) noexcept {
  ++*static_cast<int*>(self);
  return {};
}

}  // namespace

TEST_CASE("a source gives the same bytes however it cuts its pieces, and ends the ticks when it ends") {
  std::uint64_t first = 0;
  for (std::int64_t piece_us : {std::int64_t{50'000}, std::int64_t{7'000}, std::int64_t{1'300}}) {
    SceneSource scene;
    scene.end_us = 420'000;
    scene.piece_us = piece_us;
    EngineInBlock engine(SlidingScene::config());
    REQUIRE(engine->attach(scene.source()).ok());
    REQUIRE(engine->start(ClockKind::kVirtual, 50'000).ok());
    test::FrameHash hash;
    int frames = 0;
    while (engine->tick()) {
      DepthFrame frame;
      REQUIRE(engine->newest(frame));
      hash.add(frame);
      REQUIRE(++frames < 100);
    }
    CHECK(frames == 9);  // 50 .. 400 ms, and one more for what came after 400 ms
    if (first == 0) first = hash.value();
    CHECK(hash.value() == first);
    CHECK(engine->health().events.ring_dropped == 0);
    CHECK(engine->health().events.kept == 4200);
    engine->stop();
  }
}

TEST_CASE("a tap sees all events that come in, and is told of before the start") {
  struct Seen {
    std::size_t events = 0;
    std::int64_t newest_us = INT64_MIN;
    bool in_order = true;
  } seen;
  const EventTap tap{&seen, [](void* self, std::span<const Event> events) noexcept {
                       auto& s = *static_cast<Seen*>(self);
                       s.events += events.size();
                       for (const Event& event : events) {
                         s.in_order = s.in_order && event.t_us >= s.newest_us;
                         s.newest_us = event.t_us;
                       }
                     }};
  SceneSource scene;
  scene.end_us = 300'000;
  EngineInBlock engine(SlidingScene::config());
  REQUIRE(engine->watch_events(tap).ok());
  REQUIRE(engine->attach(scene.source()).ok());
  REQUIRE(engine->start(ClockKind::kVirtual, 50'000).ok());
  CHECK(engine->watch_events({}).code() == StatusCode::kBadState);
  while (engine->tick()) {
  }
  CHECK(seen.events == 3000);
  CHECK(seen.in_order);
  Engine unconfigured;
  CHECK(unconfigured.watch_events(tap).code() == StatusCode::kBadState);
}

TEST_CASE("a ring smaller than a tick's events loses none under the virtual clock") {
  Config config = SlidingScene::config();
  config.rings.events = 128;  // 500 events come per tick
  SceneSource scene;
  scene.end_us = 300'000;
  EngineInBlock engine(config);
  REQUIRE(engine->attach(scene.source()).ok());
  REQUIRE(engine->start(ClockKind::kVirtual, 50'000).ok());
  int frames = 0;
  while (engine->tick()) ++frames;
  CHECK(frames == 6);
  CHECK(engine->health().events.ring_dropped == 0);
  CHECK(engine->health().events.kept == 3000);
}

TEST_CASE("a source that never gets on costs a bounded number of polls, and the tick comes") {
  int polls = 0;
  Source source;
  source.self = &polls;
  source.poll = idle;
  EngineInBlock engine(SlidingScene::config());
  REQUIRE(engine->attach(source).ok());
  REQUIRE(engine->start(ClockKind::kVirtual, 0).ok());
  for (int i = 1; i <= 3; ++i) {
    CHECK(engine->tick());
    CHECK(polls <= 100 * i);
  }
  CHECK(engine->health().ticks.run == 3);
}

TEST_CASE("by the devices' time a tick waits for its sources however long, and gives what a replay gives") {
  const auto hash_of = [](SceneSource& scene, const Source& source, ClockKind clock) {
    EngineInBlock engine(SlidingScene::config());
    REQUIRE(engine->attach(source).ok());
    REQUIRE(engine->start(clock, 50'000).ok());
    test::FrameHash hash;
    for (DepthFrame frame; engine->tick();) {
      REQUIRE(engine->newest(frame));
      hash.add(frame);
    }
    CHECK(scene.at_us == scene.end_us);
    return hash.value();
  };
  SceneSource replayed;
  replayed.end_us = 420'000;
  SceneSource live;
  live.end_us = 420'000;
  struct Slow {
    SceneSource& scene;
    int polls = 0;
    std::int64_t shortest_us = INT64_MAX;
  } slow{live};
  Source source;
  source.self = &slow;
  // Most polls bring nothing; one that does brings more than was asked for.
  source.poll = [](void* self, Inlets& inlets, std::int64_t, std::int64_t timeout_us) noexcept {
    auto& s = *static_cast<Slow*>(self);
    s.shortest_us = std::min(s.shortest_us, timeout_us);
    if (++s.polls % 300 != 0) return Delivery{s.scene.at_us, false, {}};
    return s.scene.poll(inlets, INT64_MAX);
  };
  const std::uint64_t expected = hash_of(replayed, replayed.source(), ClockKind::kVirtual);
  CHECK(hash_of(live, source, ClockKind::kDevice) == expected);
  CHECK(slow.polls >= 300 * 60);
  CHECK(slow.shortest_us > 0);
}

TEST_CASE("by the devices' time request_stop ends a tick that waits") {
  std::atomic<int> polls{0};
  Source source;
  source.self = &polls;
  source.poll = [](void* self, Inlets&, std::int64_t, std::int64_t) noexcept {
    static_cast<std::atomic<int>*>(self)->fetch_add(1);
    return Delivery{};
  };
  EngineInBlock engine(SlidingScene::config());
  REQUIRE(engine->attach(source).ok());
  REQUIRE(engine->start(ClockKind::kDevice, 0).ok());
  std::thread other([&] {
    while (polls.load() < 1000) std::this_thread::yield();
    engine->request_stop();
  });
  CHECK_FALSE(engine->tick());
  other.join();
  CHECK(engine->health().ticks.run == 0);
}

TEST_CASE("a source that has ended before the first tick: no tick at all") {
  Source source;
  source.poll = [](void*, Inlets&, std::int64_t, std::int64_t) noexcept {
    return Delivery{INT64_MAX, true, {}};
  };
  EngineInBlock engine(SlidingScene::config());
  REQUIRE(engine->attach(source).ok());
  REQUIRE(engine->start(ClockKind::kVirtual, 0).ok());
  CHECK_FALSE(engine->tick());
  DepthFrame frame;
  CHECK_FALSE(engine->newest(frame));
}

TEST_CASE("request_stop ends the ticks under both clocks, from another thread too") {
  const ClockKind clock = GENERATE(ClockKind::kVirtual, ClockKind::kMonotonic);
  EngineInBlock engine(SlidingScene::config());
  const Clock now = monotonic_clock();
  REQUIRE(engine->start(clock, now.now_us(nullptr) + 10'000).ok());
  CHECK(engine->tick());
  std::thread other([&] { engine->request_stop(); });
  other.join();
  CHECK_FALSE(engine->tick());
  CHECK_FALSE(engine->tick());
  CHECK(engine->health().ticks.run == 1);
}

namespace {

// A live camera: pushes what has happened until now, at most every 2 ms.
struct LiveSource {
  SlidingScene scene;
  std::int64_t origin_us = 0;
  std::int64_t at_us = 0;  // since origin
  std::atomic<int> polls{0};
  std::atomic<int> stops{0};

  Source source() {
    Source s;
    s.self = this;
    s.poll = [](void* self, Inlets& inlets, std::int64_t, std::int64_t timeout_us) noexcept {
      return static_cast<LiveSource*>(self)->poll(inlets, timeout_us);
    };
    s.stop = [](void* self) noexcept { static_cast<LiveSource*>(self)->stops.fetch_add(1); };
    return s;
  }

  Delivery poll(Inlets& inlets, std::int64_t timeout_us) noexcept {
    polls.fetch_add(1);
    const Clock clock = monotonic_clock();
    clock.sleep_until_us(clock.self, clock.now_us(clock.self) + std::min<std::int64_t>(timeout_us, 2000));
    const std::int64_t to_us = clock.now_us(clock.self) - origin_us;
    std::vector<Event> events = scene.events(at_us, to_us);
    for (Event& e : events) e.t_us += origin_us;
    std::vector<PoseSample> poses = SlidingScene::poses(at_us, to_us);
    for (PoseSample& p : poses) p.t_us += origin_us;
    inlets.push(poses);
    inlets.push(events);
    at_us = to_us;
    return {origin_us + at_us, false, {}};
  }
};

}  // namespace

TEST_CASE("on the monotonic clock frames come at the rate, and stop joins the source's thread") {
  Config config = SlidingScene::config();
  config.ladder.hypotheses = 8;
  config.rate.rate_hz = 50;
  config.rate.lateness_us = 5000;
  config.threads = 2;
  const Clock clock = monotonic_clock();
  LiveSource live;
  live.origin_us = clock.now_us(clock.self);
  EngineInBlock engine(config);
  REQUIRE(engine->attach(live.source()).ok());
  const std::int64_t first_us = live.origin_us + 300'000;
  REQUIRE(engine->start(ClockKind::kMonotonic, first_us).ok());
  std::uint64_t before = 0;
  int frames = 0;
  DepthFrame frame;
  while (frames < 25 && clock.now_us(clock.self) < first_us + 5'000'000) {
    REQUIRE(engine->tick());
    const std::int64_t now_us = clock.now_us(clock.self);
    REQUIRE(engine->newest(frame));
    REQUIRE(frame.t_us == first_us + static_cast<std::int64_t>(frame.sequence) * 20'000);
    CHECK(now_us >= frame.t_us + 5000);
    CHECK(frame.latency_us >= 5000);
    CHECK(frame.latency_us <= now_us - frame.t_us);
    CHECK(((frames == 0) || frame.sequence > before));
    before = frame.sequence;
    ++frames;
  }
  engine->stop();
  CHECK(live.stops.load() == 1);
  const int polls = live.polls.load();
  const Health health = engine->health();
  // However slow the machine: what did not run was skipped, and counted.
  CHECK(health.ticks.run == 25);
  CHECK(health.ticks.run + health.ticks.skipped >= before + 1);
  CHECK(health.events.kept > 0);
  CHECK(health.poses.used > 0);
  WARN("25 ticks at 50 Hz: " << health.ticks.skipped << " skipped, " << health.ticks.late
                             << " late, last flags " << frame.flags);
  clock.sleep_until_us(clock.self, clock.now_us(clock.self) + 20'000);
  CHECK(live.polls.load() == polls);
}

TEST_CASE("samples of a clock gone wrong do not block the rings, and do not stop the motion") {
  Config config = SlidingScene::config();
  config.ladder.hypotheses = 8;
  const Clock clock = monotonic_clock();
  const std::int64_t origin_us = clock.now_us(clock.self) - 240'000;
  EngineInBlock engine(config);
  REQUIRE(engine->start(ClockKind::kMonotonic, origin_us + 250'000).ok());
  SlidingScene scene;
  std::vector<Event> events = scene.events(0, 250'000);
  for (Event& e : events) e.t_us += origin_us;
  const Event garbage{origin_us + 10'000'000, 1, 1, 1};
  const Event worst{INT64_MAX, 1, 1, 1};
  engine->inlets().push({&garbage, 1});
  engine->inlets().push({&worst, 1});
  engine->inlets().push(events);
  std::vector<PoseSample> poses = SlidingScene::poses(0, 250'000);
  PoseSample future = poses.back();
  future.t_us = origin_us + 60'000'000;
  for (int i = 0; i < 100; ++i) engine->inlets().push({&future, 1});
  for (PoseSample& p : poses) p.t_us += origin_us;
  engine->inlets().push(poses);
  REQUIRE(engine->tick());
  const Health health = engine->health();
  CHECK(health.events.ahead == 2);
  CHECK(health.events.kept == 2500);
  CHECK(health.poses.invalid == 100);
  CHECK(health.poses.used == 50);
  CHECK(health.poses.in == 150);
  DepthFrame frame;
  REQUIRE(engine->newest(frame));
  CHECK((frame.flags & ~static_cast<std::uint32_t>(kLateTick)) == 0);
  CHECK(frame.events > 0);
}

TEST_CASE("a lost device ends its source and shows in the health, on both clocks") {
  int polls = 0;
  Source lost;
  lost.self = &polls;
  lost.name = "unplugged";
  lost.poll = [](void* self, Inlets&, std::int64_t, std::int64_t) noexcept -> Delivery {
    ++*static_cast<int*>(self);
    return {INT64_MIN, false, {StatusCode::kIo, "camera unplugged", 19}};
  };
  for (ClockKind clock : {ClockKind::kVirtual, ClockKind::kMonotonic}) {
    polls = 0;
    EngineInBlock engine(SlidingScene::config());
    SceneSource scene;
    scene.end_us = INT64_MAX / 4;
    REQUIRE(engine->attach(lost).ok());
    if (clock == ClockKind::kVirtual) REQUIRE(engine->attach(scene.source()).ok());
    const Clock host = monotonic_clock();
    const std::int64_t now_us = clock == ClockKind::kVirtual ? 0 : host.now_us(host.self);
    REQUIRE(engine->start(clock, now_us + 50'000).ok());
    for (int i = 0; i < 3; ++i) REQUIRE(engine->tick());
    CHECK(engine->health().sources_lost == 1);
    engine->stop();
    CHECK(polls == 1);
  }
}
