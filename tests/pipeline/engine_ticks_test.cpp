// Ticks at any time under the virtual clock: what is asked for, what is refused, and that depth does not
// depend on when else there were ticks.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "support/engine_in_block.hpp"
#include "support/frame_hash.hpp"
#include "support/sliding_scene.hpp"

using namespace egofocus;
using test::EngineInBlock;
using test::SlidingScene;

namespace {

constexpr std::int64_t kPeriod_us = 50'000;
constexpr std::int64_t kLatest_us = std::int64_t{1} << 60;

/// What a frame says that is not about the ticks themselves: no sequence number.
std::uint64_t hash_of(DepthFrame frame) {
  frame.sequence = 0;
  test::FrameHash hash;
  hash.add(frame);
  return hash.value();
}

/// Time -> hash of the frame of a tick there. Samples come just before their tick, all kinds at once.
std::map<std::int64_t, std::uint64_t> frames_at(const std::vector<std::int64_t>& times, MotionSource source) {
  Config config = SlidingScene::config();
  config.motion.source = source;
  config.filter.refractory_us = 300;
  config.filter.hot_pixel_rate_hz = 400;
  config.filter.hot_pixel_learn_us = 300'000;
  config.rings = {1u << 16, 1u << 10, 1u << 10, 1u << 10};
  EngineInBlock engine(config);
  REQUIRE(engine.status.ok());
  REQUIRE(engine->start(ClockKind::kVirtual, times.front()).ok());
  const SlidingScene scene;
  std::map<std::int64_t, std::uint64_t> frames;
  std::int64_t fed_us = 0;
  for (const std::int64_t t_us : times) {
    REQUIRE(engine->set_next_tick(t_us).ok());
    REQUIRE(engine->next_tick_us() == t_us);
    const auto events = scene.events(fed_us, t_us);
    const auto imu = SlidingScene::imu(fed_us, t_us);
    const auto odometry = SlidingScene::odometry(fed_us, t_us);
    const auto poses = SlidingScene::poses(fed_us, t_us);
    REQUIRE(engine->inlets().push(events) == events.size());
    REQUIRE(engine->inlets().push(imu) == imu.size());
    REQUIRE(engine->inlets().push(odometry) == odometry.size());
    REQUIRE(engine->inlets().push(poses) == poses.size());
    fed_us = t_us;
    REQUIRE(engine->tick());
    DepthFrame frame;
    REQUIRE(engine->newest(frame));
    REQUIRE(frame.t_us == t_us);
    if (t_us > 300'000) REQUIRE(frame.votes > 0);
    frames[t_us] = hash_of(frame);
  }
  const Health health = engine->health();
  CHECK(health.events.kept > 0);
  CHECK(health.events.late == 0);
  CHECK(health.imu.late == 0);
  CHECK(health.odometry.late == 0);
  CHECK(health.poses.late == 0);
  CHECK(health.ticks.run == times.size());
  return frames;
}

}  // namespace

TEST_CASE("a frame does not depend on when else there were ticks") {
  const MotionSource source = GENERATE(MotionSource::kPoses, MotionSource::kOdometry);
  std::vector<std::int64_t> grid;
  for (std::int64_t k = 1; k <= 20; ++k) grid.push_back(k * kPeriod_us);
  // Jitter, a pair one microsecond apart, and a pause; six times are of the grid.
  const std::vector<std::int64_t> irregular = {37'003,  50'000,  50'001,  100'000, 183'777,
                                               300'000, 349'999, 350'000, 900'000, 1'000'000};
  const auto expected = frames_at(grid, source);
  const auto found = frames_at(irregular, source);
  int compared = 0;
  for (const auto& [t_us, hash] : found) {
    const auto same = expected.find(t_us);
    if (same == expected.end()) continue;
    INFO(t_us << " us");
    CHECK(hash == same->second);
    ++compared;
  }
  CHECK(compared == 6);
  CHECK(found.at(50'000) != found.at(50'001));
}

TEST_CASE("a pause longer than what sorts the motion samples can hold loses none") {
  // 4 s of 200 Hz: 800 samples of each kind wait for one tick.
  const auto expected = frames_at({1'000'000, 2'000'000, 3'000'000, 4'000'000}, MotionSource::kOdometry);
  const auto found = frames_at({4'000'000}, MotionSource::kOdometry);
  CHECK(found.at(4'000'000) == expected.at(4'000'000));
}

TEST_CASE("a tick can be set sooner and later, and the grid goes on from there") {
  EngineInBlock engine(SlidingScene::config());
  REQUIRE(engine->start(ClockKind::kVirtual, 100'000).ok());
  REQUIRE(engine->set_next_tick(20'000).ok());
  std::vector<std::int64_t> times;
  std::vector<std::uint64_t> numbers;
  const auto tick = [&] {
    REQUIRE(engine->tick());
    DepthFrame frame;
    REQUIRE(engine->newest(frame));
    times.push_back(frame.t_us);
    numbers.push_back(frame.sequence);
  };
  tick();
  tick();
  REQUIRE(engine->set_next_tick(70'001).ok());
  REQUIRE(engine->set_next_tick(333'333).ok());
  tick();
  tick();
  CHECK(times == std::vector<std::int64_t>{20'000, 70'000, 333'333, 383'333});
  CHECK(numbers == std::vector<std::uint64_t>{0, 1, 2, 3});
}

TEST_CASE("a tick that cannot be is refused, and nothing changes") {
  const auto text = [](const Status& status) {
    char line[200];
    return std::string(line, status.describe(line));
  };
  Engine none;
  CHECK(none.set_next_tick(1).code() == StatusCode::kBadState);
  EngineInBlock engine(SlidingScene::config());
  CHECK(engine->set_next_tick(1).code() == StatusCode::kBadState);
  REQUIRE(engine->start(ClockKind::kVirtual, kPeriod_us).ok());
  CHECK(engine->set_next_tick(-kLatest_us).code() == StatusCode::kBadTick);
  CHECK(engine->set_next_tick(INT64_MIN).code() == StatusCode::kBadTick);
  CHECK(engine->next_tick_us() == kPeriod_us);
  REQUIRE(engine->tick());
  const Status past = engine->set_next_tick(kPeriod_us);
  CHECK(past.code() == StatusCode::kBadTick);
  CHECK(past.value() == kPeriod_us);
  CHECK(past.bound() == kPeriod_us);
  CHECK(text(past) == "no tick can be at 50000 us: it must come after the last one, 50000 us");
  CHECK(engine->set_next_tick(kPeriod_us - 1).code() == StatusCode::kBadTick);
  CHECK(engine->set_next_tick(kLatest_us + 1).bound() == kLatest_us);
  CHECK(engine->set_next_tick(INT64_MAX).code() == StatusCode::kBadTick);
  CHECK(engine->next_tick_us() == 2 * kPeriod_us);
  CHECK(engine->set_next_tick(kPeriod_us + 1).ok());
  CHECK(engine->set_next_tick(kLatest_us).ok());
  REQUIRE(engine->tick());
  CHECK(engine->next_tick_us() == kLatest_us + kPeriod_us);
  engine->stop();
  CHECK(engine->set_next_tick(kLatest_us).code() == StatusCode::kBadState);

  EngineInBlock live(SlidingScene::config());
  REQUIRE(live->start(ClockKind::kMonotonic, kPeriod_us).ok());
  CHECK(live->set_next_tick(2 * kPeriod_us).code() == StatusCode::kBadState);
  CHECK_THAT(text(live->set_next_tick(2 * kPeriod_us)), Catch::Matchers::Contains("monotonic clock"));
  CHECK(live->next_tick_us() == kPeriod_us);
}
