// Whole ticks under the virtual clock: bytes, flags, counters.
#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "support/engine_in_block.hpp"
#include "support/frame_hash.hpp"
#include "support/sliding_scene.hpp"

using namespace egofocus;
using test::EngineInBlock;
using test::SlidingScene;

namespace {

constexpr std::int64_t kPeriod_us = 50'000;

// Feeds what belongs to the next tick, and ticks.
class FedEngine {
 public:
  explicit FedEngine(const Config& config) : engine_(config) {
    REQUIRE(engine_.status.ok());
    REQUIRE(engine_->start(ClockKind::kVirtual, kPeriod_us).ok());
  }

  DepthFrame tick(bool with_events = true, bool with_poses = true) {
    const std::int64_t until_us = engine_->next_tick_us();
    if (with_events) REQUIRE(push(scene_.events(fed_until_us_, until_us)) > 0);
    if (with_poses) engine_->inlets().push(SlidingScene::poses(fed_until_us_, until_us));
    fed_until_us_ = until_us;
    REQUIRE(engine_->tick());
    DepthFrame frame;
    REQUIRE(engine_->newest(frame));
    return frame;
  }
  std::size_t push(const std::vector<Event>& events) { return engine_->inlets().push(events); }
  Engine& operator*() { return *engine_; }

 private:
  SlidingScene scene_;
  EngineInBlock engine_;
  std::int64_t fed_until_us_ = 0;
};

std::uint64_t run_hash(Config config, int ticks) {
  FedEngine engine(config);
  test::FrameHash hash;
  for (int i = 0; i < ticks; ++i) hash.add(engine.tick());
  return hash.value();
}

std::uint64_t accounted(const EventCounters& c) {
  return c.ring_dropped + c.out_of_range + c.out_of_order + c.ahead + c.late + c.hot_pixel + c.refractory +
         c.isolated + c.kept;
}

}  // namespace

TEST_CASE("a slide past a wall gives the wall's distance") {
  FedEngine engine(SlidingScene::config());
  DepthFrame frame;
  for (int i = 0; i < 8; ++i) frame = engine.tick();
  CHECK(frame.flags == 0);
  CHECK(frame.sequence == 7);
  CHECK(frame.t_us == 8 * kPeriod_us);
  CHECK(frame.age_us == 0);
  CHECK(frame.latency_us == 0);
  CHECK(frame.events == 2001);
  CHECK(frame.parallax_px == Approx(24 * 23.0 / 31));  // of 32 hypotheses the nearest 8 are left out
  CHECK(frame.velocity_m_s[0] == Approx(SlidingScene::kSpeed_m_s));
  std::vector<float> depth(frame.inverse_depth.size());
  REQUIRE(metric_depth(frame, 100, depth) == 64u * 48u);
  std::vector<float> known;
  std::copy_if(depth.begin(), depth.end(), std::back_inserter(known), [](float d) { return d > 0; });
  REQUIRE(known.size() > depth.size() / 2);
  std::sort(known.begin(), known.end());
  // 6 px of motion in whole pixels: one pixel is 17 %.
  CHECK(known[known.size() / 2] == Approx(SlidingScene::kDistance_m).epsilon(0.15));
  const Health health = (*engine).health();
  CHECK(health.state == RunState::kRunning);
  CHECK(health.cause == Cause::kNone);
  CHECK(health.ticks.run == 8);
  CHECK(health.events.in == 4000);
  CHECK(health.events.kept == 4000);
  CHECK(health.poses.in == 80);
  CHECK(health.poses.used == 80);
}

TEST_CASE("the same bytes on every machine, for every number of threads, in debug and release") {
  const int threads = GENERATE(1, 2, 3);
  for (FocusCost cost : {FocusCost::kGradient, FocusCost::kSoe, FocusCost::kSti}) {
    Config config = SlidingScene::config();
    config.threads = threads;
    config.focus.cost = cost;
    config.camera.distortion = Distortion::kEquidistant;
    config.camera.coefficients[0] = -0.048;
    config.filter.refractory_us = 300;
    config.focus.smoothing = cost != FocusCost::kSoe;
    const std::uint64_t expected = cost == FocusCost::kGradient ? 0x0cfed36d5d4d892au
                                   : cost == FocusCost::kSoe    ? 0x9543e4ae0935270eu
                                                                : 0x72babebc569467dfu;
    INFO("cost " << static_cast<int>(cost) << ", threads " << threads);
    CHECK(run_hash(config, 6) == expected);
  }
}

TEST_CASE("two engines side by side do not see each other") {
  const std::uint64_t alone = run_hash(SlidingScene::config(), 5);
  Config other = SlidingScene::config();
  other.focus.cost = FocusCost::kVariance;
  FedEngine a(SlidingScene::config());
  FedEngine b(other);
  test::FrameHash hash_a;
  test::FrameHash hash_b;
  for (int i = 0; i < 5; ++i) {
    hash_a.add(a.tick());
    hash_b.add(b.tick());
  }
  CHECK(hash_a.value() == alone);
  CHECK(hash_b.value() != alone);
}

TEST_CASE("ticks without any sample: blank frames on time, and the reason") {
  FedEngine engine(SlidingScene::config());
  for (std::uint64_t i = 0; i < 3; ++i) {
    const DepthFrame frame = engine.tick(false, false);
    CHECK(frame.flags == kNoMotion);
    CHECK(frame.sequence == i);
    CHECK(frame.age_us == INT64_MAX);
    CHECK(frame.events == 0);
    CHECK(std::count(frame.confidence.begin(), frame.confidence.end(), 0) == 64 * 48);
    CHECK(std::count(frame.inverse_depth.begin(), frame.inverse_depth.end(), 0) == 64 * 48);
  }
  const Health health = (*engine).health();
  CHECK(health.state == RunState::kWaiting);
  CHECK(health.cause == Cause::kNoEvents);
  CHECK(health.ticks.run == 3);
  CHECK(health.ticks.no_motion == 3);
}

TEST_CASE("events without motion stall, motion without events stalls: each says which") {
  Config config = SlidingScene::config();
  config.window.min_events = 0;
  config.carry.max_age_us = 0;
  FedEngine engine(config);
  CHECK(engine.tick(true, false).flags == kNoMotion);
  CHECK((*engine).health().cause == Cause::kNoMotion);
  CHECK((*engine).health().state == RunState::kStalled);
  for (int i = 0; i < 4; ++i) engine.tick();
  CHECK((*engine).health().state == RunState::kRunning);
  DepthFrame frame;
  for (int i = 0; i < 5; ++i) frame = engine.tick(false, true);
  CHECK(frame.flags == kTooFewEvents);  // none at all: whatever the configured minimum
  CHECK(frame.age_us == 5 * kPeriod_us);
  CHECK((*engine).health().state == RunState::kStalled);
  CHECK((*engine).health().cause == Cause::kNoEvents);
}

TEST_CASE("a standstill has no parallax; stopped motion samples are stale, then none") {
  SECTION("standstill") {
    FedEngine engine(SlidingScene::config());
    for (int i = 0; i < 4; ++i) {
      std::vector<PoseSample> still = SlidingScene::poses(i * kPeriod_us, (i + 1) * kPeriod_us);
      for (PoseSample& p : still) p.position_m[0] = 3;
      (*engine).inlets().push(still);
      const DepthFrame frame = engine.tick(true, false);
      CHECK((frame.flags & kNoParallax) != 0);
      CHECK(std::count(frame.confidence.begin(), frame.confidence.end(), 0) == 64 * 48);
    }
    CHECK((*engine).health().cause == Cause::kNoParallax);
    CHECK((*engine).health().ticks.no_parallax == 4);
  }
  SECTION("stale") {
    FedEngine engine(SlidingScene::config());
    for (int i = 0; i < 5; ++i) engine.tick();
    CHECK(engine.tick(true, false).flags == 0);  // 50 ms old
    CHECK(engine.tick(true, false).flags == 0);  // 100 ms old: just allowed
    const DepthFrame frame = engine.tick(true, false);
    CHECK(frame.flags == kStaleVelocity);
    CHECK(frame.events > 0);
    CHECK((*engine).health().state == RunState::kDegraded);
    for (int i = 0; i < 20; ++i) engine.tick(true, false);
    CHECK(engine.tick(true, false).flags == kNoMotion);
    CHECK((*engine).health().ticks.stale_velocity == 18);
  }
}

TEST_CASE("every event that goes in is counted on one line") {
  Config config = SlidingScene::config();
  config.rings.events = 1024;
  FedEngine engine(config);
  engine.tick();
  std::vector<Event> events = {{10, 1, 1, 1},                  // long past
                               {kPeriod_us, 1, 1, 1},          // its tick has just run
                               {INT64_MIN, 1, 1, 1},           // no time at all
                               {kPeriod_us + 5000, 64, 1, 1},  // outside
                               {kPeriod_us + 5000, 1, 48, 1},  // outside
                               {kPeriod_us + 5000, 1, 1, 1},   // good
                               {kPeriod_us + 4999, 1, 1, 1},   // back in time
                               {2 * kPeriod_us, 2, 2, 0}};     // good, on the edge
  REQUIRE(engine.push(events) == events.size());
  engine.tick(false, true);
  EventCounters c = (*engine).health().events;
  CHECK(c.late == 3);
  CHECK(c.out_of_range == 2);
  CHECK(c.out_of_order == 1);
  CHECK(c.kept == 502);
  CHECK(c.in == 508);
  CHECK(accounted(c) == c.in);

  SECTION("a full ring drops, counts, and flags the frame") {
    std::vector<Event> flood(1500, Event{2 * kPeriod_us + 10, 3, 3, 1});
    CHECK(engine.push(flood) == 1024);
    const DepthFrame frame = engine.tick(false, true);
    CHECK((frame.flags & kOverload) != 0);
    c = (*engine).health().events;
    CHECK(c.ring_dropped == 476);
    CHECK(accounted(c) == c.in);
    CHECK((engine.tick().flags & kOverload) == 0);
  }
  SECTION("more than the window's maximum are decimated, counted, and flagged") {
    std::vector<Event> flood;
    for (int round = 0; round < 5; ++round) {
      flood.assign(1020, Event{(2 + round) * kPeriod_us + 10, 3, 3, 1});
      CHECK(engine.push(flood) == 1020);
      const DepthFrame frame = engine.tick(false, true);
      CHECK(((frame.flags & kOverload) != 0) == (frame.events == 4000));
    }
    CHECK((*engine).health().window.decimated > 0);
  }
  SECTION("an event of the future waits for its tick") {
    REQUIRE(engine.push({{4 * kPeriod_us - 1, 5, 5, 1}}) == 1);
    engine.tick(false, true);
    CHECK((*engine).health().events.kept == 502);
    engine.tick(false, true);
    CHECK((*engine).health().events.kept == 503);
  }
}

TEST_CASE("time stamps at the ends of int64 are counted, and break nothing") {
  FedEngine engine(SlidingScene::config());
  const std::int64_t far = std::int64_t{1} << 62;
  REQUIRE(engine.push({{INT64_MIN, 1, 1, 1}, {INT64_MIN + 1, 1, 1, 1}, {-far, 2, 2, 1}, {5, 3, 3, 1}}) == 4);
  PoseSample pose;
  pose.t_us = INT64_MIN;
  (*engine).inlets().push({&pose, 1});
  engine.tick(false, true);
  const Health health = (*engine).health();
  CHECK(health.events.late == 3);
  CHECK(health.events.kept == 1);
  CHECK(health.poses.invalid == 1);
  CHECK(health.poses.in == 11);
}
