// Every way in which configure(), attach() and start() refuse, and the arena's exact size.
#include <catch2/catch.hpp>
#include <cerrno>
#include <limits>
#include <string>

#include "support/engine_in_block.hpp"
#include "support/sliding_scene.hpp"

using namespace egofocus;
using test::EngineInBlock;
using test::SlidingScene;

namespace {

std::string text(const Status& status) {
  char line[256];
  return {line, status.describe(line)};
}

// The status of required_arena(), which configure() must repeat without touching the block.
Status refusal(const Config& config) {
  std::size_t bytes = 1;
  const Status status = Engine::required_arena(config, bytes);
  CHECK(bytes == 0);
  test::ArenaBlock block(64);
  Engine engine;
  const Status again = engine.configure(config, block.span());
  CHECK(again.code() == status.code());
  CHECK(std::string(again.subject()) == status.subject());
  CHECK(engine.start(ClockKind::kVirtual, 0).code() == StatusCode::kBadState);  // nothing is half-started
  return status;
}

std::size_t arena_bytes(const Config& config) {
  std::size_t bytes = 0;
  REQUIRE(Engine::required_arena(config, bytes).ok());
  return bytes;
}

Config default_config() {
  Config config;
  config.backend = Backend::kFocus;
  config.camera.intrinsics = {346, 260, 226, 226, 173, 130};
  return config;
}

Delivery nothing(void*, Inlets&, std::int64_t, std::int64_t) noexcept {
  return {};
}

}  // namespace

TEST_CASE("each cause of refusal has its own code, and a text that names the field") {
  const Pixel outside[] = {{64, 0}};
  struct Case {
    StatusCode code;
    const char* field;
    void (*spoil)(Config&);
  };
  const Case cases[] = {
      {StatusCode::kBadResolution, "camera size", [](Config& c) { c.camera.intrinsics.width_px = 0; }},
      {StatusCode::kBadResolution, "grid size", [](Config& c) { c.grid = {4, 4, 1, 1, 1, 1}; }},
      {StatusCode::kBadIntrinsics, "camera focal", [](Config& c) { c.camera.intrinsics.fx_px = 1e9; }},
      {StatusCode::kBadIntrinsics, "camera centre",
       [](Config& c) { c.camera.intrinsics.cy_px = std::numeric_limits<double>::quiet_NaN(); }},
      {StatusCode::kBadDistortion, "column",
       [](Config& c) {
         c.camera.distortion = Distortion::kPlumbBob;
         c.camera.coefficients[0] = -9;
       }},
      {StatusCode::kBadLadder, "hypotheses", [](Config& c) { c.ladder.hypotheses = 36; }},
      {StatusCode::kBadWindow, "max_events", [](Config& c) { c.window.max_events = 0; }},
      {StatusCode::kBadFilter, "refractory", [](Config& c) { c.filter.refractory_us = -1; }},
      {StatusCode::kBadMotion, "camera_from_body", [](Config& c) { c.motion.camera_from_body[0] = 1; }},
      {StatusCode::kBadFocus, "support_cells", [](Config& c) { c.focus.support_cells = 4; }},
      {StatusCode::kBadCarry, "max_travel", [](Config& c) { c.carry.max_travel = 2; }},
      {StatusCode::kBadRate, "rate_hz", [](Config& c) { c.rate.rate_hz = 0; }},
      {StatusCode::kBadRate, "lateness", [](Config& c) { c.rate.lateness_us = -1; }},
      {StatusCode::kBadRing, "rings.events", [](Config& c) { c.rings.events = 1000; }},
      {StatusCode::kBadRing, "rings.max_event_rate_hz (0, or 10000 and more)",
       [](Config& c) { c.rings.max_event_rate_hz = 9'999; }},
      {StatusCode::kBadRing, "rings.events is too small for max_event_rate_hz over a period and lateness_us",
       [](Config& c) { c.rings.max_event_rate_hz = 2'000'000; }},
      {StatusCode::kBadRate, "rate.max_late_us", [](Config& c) { c.rate.max_late_us = -1; }},
      {StatusCode::kBadRing, "rings.imu", [](Config& c) { c.rings.imu = 32; }},
      {StatusCode::kBadRing, "rings.odometry", [](Config& c) { c.rings.odometry = 0; }},
      {StatusCode::kBadRing, "rings.poses", [](Config& c) { c.rings.poses = 1u << 25; }},
      {StatusCode::kBadThreads, "threads", [](Config& c) { c.threads = 9; }},
      {StatusCode::kBadThreads, "threads", [](Config& c) { c.threads = 0; }},
      {StatusCode::kBadThreads, "fifo_priority", [](Config& c) { c.real_time.fifo_priority = 100; }},
  };
  for (const Case& c : cases) {
    Config config = SlidingScene::config();
    c.spoil(config);
    const Status status = refusal(config);
    INFO(c.field << ": " << text(status));
    CHECK(status.code() == c.code);
    CHECK(text(status).find(c.field) != std::string::npos);
    CHECK(text(status).size() > 20);
  }
  Config config = SlidingScene::config();
  config.filter.hot_pixels = outside;
  CHECK(refusal(config).code() == StatusCode::kBadFilter);
}

TEST_CASE("an arena one byte too small names the bytes, a misaligned one says so") {
  const Config config = SlidingScene::config();
  const std::size_t bytes = arena_bytes(config);
  test::ArenaBlock block(bytes + 64);
  Engine engine;
  const Status small = engine.configure(config, block.span().first(bytes - 1));
  CHECK(small.code() == StatusCode::kArenaTooSmall);
  CHECK(small.value() == static_cast<std::int64_t>(bytes - 1));
  CHECK(small.bound() == static_cast<std::int64_t>(bytes));
  CHECK(text(small).find(std::to_string(bytes)) != std::string::npos);
  CHECK(engine.configure(config, {}).code() == StatusCode::kArenaTooSmall);
  const Status crooked = engine.configure(config, block.span().subspan(8, bytes));
  CHECK(crooked.code() == StatusCode::kArenaMisaligned);
  CHECK(crooked.value() == 8);
  CHECK(engine.configure(config, block.span().first(bytes)).ok());
  // The byte behind was never touched: ArenaBlock's pattern is still there.
  CHECK(block.span()[bytes] == std::byte{0xa5});
}

TEST_CASE("the arena's size is what it is: growth has to be meant") {
  Config sti = default_config();
  sti.camera.intrinsics = {240, 180, 200, 200, 120, 90};
  sti.focus.cost = FocusCost::kSti;
  Config d48 = default_config();
  d48.ladder.hypotheses = 48;
  const bool wide = sizeof(void*) == 8;
  CHECK(arena_bytes(default_config()) == (wide ? 22420288u : 22413312u));
  CHECK(arena_bytes(d48) == (wide ? 18456512u : 18449536u));
  CHECK(arena_bytes(sti) == (wide ? 12994944u : 12987968u));
}

TEST_CASE("more than the address space is too small an arena, not a small one") {
  Arena counter;
  static_cast<void>(counter.array<std::uint64_t>(SIZE_MAX / 2));
  static_cast<void>(counter.array<std::uint64_t>(100));
  CHECK(counter.used_bytes() > SIZE_MAX - 128);
}

TEST_CASE("calls in the wrong order are refused, and do no harm") {
  Engine raw;
  CHECK(raw.attach({}).code() == StatusCode::kBadState);
  CHECK(raw.start(ClockKind::kVirtual, 0).code() == StatusCode::kBadState);
  CHECK_FALSE(raw.tick());
  DepthFrame frame;
  CHECK_FALSE(raw.newest(frame));
  CHECK(raw.next_tick_us() == INT64_MIN);
  CHECK(raw.health().state == RunState::kWaiting);
  CHECK(std::string(raw.isa()).empty());
  raw.request_stop();
  raw.stop();

  EngineInBlock engine(SlidingScene::config());
  REQUIRE(engine.status.ok());
  CHECK_FALSE(std::string(engine->isa()).empty());
  CHECK_FALSE(engine->tick());
  CHECK(text(engine->attach({})).find("poll") != std::string::npos);
  test::ArenaBlock other(1 << 20);
  CHECK(engine->configure(SlidingScene::config(), other.span()).code() == StatusCode::kBadState);
  REQUIRE(engine->start(ClockKind::kVirtual, 50'000).ok());
  CHECK(engine->start(ClockKind::kVirtual, 0).code() == StatusCode::kBadState);
  Source source;
  source.poll = nothing;
  CHECK(engine->attach(source).code() == StatusCode::kBadState);
  CHECK(engine->next_tick_us() == 50'000);
  CHECK(engine->tick());
  engine->stop();
  CHECK_FALSE(engine->tick());
  engine->stop();
}

TEST_CASE("the ninth source is one too many") {
  EngineInBlock engine(SlidingScene::config());
  Source source;
  source.poll = nothing;
  for (int i = 0; i < 8; ++i) REQUIRE(engine->attach(source).ok());
  const Status status = engine->attach(source);
  CHECK(status.code() == StatusCode::kTooManySources);
  CHECK(text(status).find("8") != std::string::npos);
}

TEST_CASE("a source that does not start ends the start: what was started is stopped, the rest untouched") {
  struct Counted {
    int starts = 0;
    int stops = 0;
    bool fails = false;
  } sources[3];
  sources[1].fails = true;
  EngineInBlock engine(SlidingScene::config());
  for (Counted& counted : sources) {
    Source source;
    source.self = &counted;
    source.start = [](void* self) noexcept {
      auto& c = *static_cast<Counted*>(self);
      ++c.starts;
      return c.fails ? Status(StatusCode::kIo, "camera unplugged", ENODEV) : Status();
    };
    source.poll = nothing;
    source.stop = [](void* self) noexcept { ++static_cast<Counted*>(self)->stops; };
    REQUIRE(engine->attach(source).ok());
  }
  const ClockKind clock = GENERATE(ClockKind::kVirtual, ClockKind::kMonotonic);
  const Status status = engine->start(clock, 0);
  CHECK(status.code() == StatusCode::kIo);
  CHECK(status.value() == ENODEV);
  CHECK(sources[0].starts == 1);
  CHECK(sources[0].stops == 1);
  CHECK(sources[1].starts == 1);
  CHECK(sources[1].stops == 0);
  CHECK(sources[2].starts == 0);
  CHECK(sources[2].stops == 0);
  CHECK_FALSE(engine->tick());
  sources[1].fails = false;  // plugged in again
  CHECK(engine->start(ClockKind::kVirtual, 0).ok());
  engine->stop();
  CHECK(sources[0].stops == 2);
  CHECK(sources[2].stops == 1);
}
