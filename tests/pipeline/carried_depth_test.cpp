// Depth carried through whole ticks, and the limits at which it ends. The scene slides, stops, turns and goes
// on; where a kept pixel must lie follows from the poses.
#include "pipeline/carried_depth.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/elementary.hpp"
#include "support/arena_block.hpp"
#include "support/engine_in_block.hpp"
#include "support/frame_hash.hpp"
#include "support/sliding_scene.hpp"

using namespace egofocus;
using test::EngineInBlock;
using test::SlidingScene;

namespace {

constexpr std::int64_t kPeriod_us = 50'000;
constexpr Intrinsics kGrid{32, 24, 40, 40, 15.5, 11.5};
constexpr std::size_t kPixels = 32 * 24;

/// A frame whose pixel i has inverse depth 100 + i, and all of it full confidence.
struct Frame {
  std::vector<std::uint16_t> inverse_depth = std::vector<std::uint16_t>(kPixels);
  std::vector<std::uint8_t> confidence = std::vector<std::uint8_t>(kPixels, 255);
  DepthFrame frame;
  Frame() {
    for (std::size_t i = 0; i < kPixels; ++i) inverse_depth[i] = static_cast<std::uint16_t>(100 + i);
    frame.t_us = 1'000'000;
    frame.grid = kGrid;
    frame.inverse_depth_scale_per_m = 1e-3;
    frame.inverse_depth = inverse_depth;
    frame.confidence = confidence;
  }
};

struct Shown {
  bool any = false;
  DepthFrame frame;
  std::vector<std::uint16_t> inverse_depth = std::vector<std::uint16_t>(kPixels);
  std::vector<std::uint8_t> confidence = std::vector<std::uint8_t>(kPixels);
};

MotionTrack still(std::int64_t begin_us, std::int64_t end_us) {
  MotionTrack track;
  track.begin_us = begin_us;
  track.end_us = end_us;
  for (MotionKnot& knot : track.knots) knot = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
  return track;
}

/// Turns by `yaw` about the vertical and moves by `ahead_m`, both during this track.
MotionTrack moving(std::int64_t begin_us, std::int64_t end_us, double yaw, double ahead_m) {
  MotionTrack track = still(begin_us, end_us);
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  track.knots[0] = {{c, 0, -s, 0, 1, 0, s, 0, c}, {0, 0, -ahead_m}};
  return track;
}

Shown show(CarriedDepth& carried, const MotionTrack& motion) {
  Shown out;
  out.any = carried.show(motion, out.frame, out.inverse_depth, out.confidence);
  return out;
}

std::span<std::uint32_t> landed(Arena& arena) {
  return arena.array<std::uint32_t>(static_cast<std::size_t>(kGrid.width_px * kGrid.height_px));
}

Status checked(std::int64_t max_age_us, double max_travel, double min_in_view) {
  return CarriedDepth::check({max_age_us, max_travel, min_in_view});
}

/// An engine that is fed any poses with the sliding scene's events.
class Walk {
 public:
  explicit Walk(const Config& config) : engine_(config) {
    REQUIRE(engine_.status.ok());
    REQUIRE(engine_->start(ClockKind::kVirtual, kPeriod_us).ok());
  }
  /// A tick until which the camera moves with `speed_m_s` to the right and turns with `rate_rad_s` about the
  /// optical axis.
  DepthFrame tick(double speed_m_s, double rate_rad_s = 0, bool with_events = true) {
    const std::int64_t until_us = engine_->next_tick_us();
    if (with_events) engine_->inlets().push(scene_.events(until_us - kPeriod_us, until_us));
    for (std::int64_t t = until_us - kPeriod_us + 5000; t <= until_us; t += 5000) {
      // Right is right of the turned camera, so that speed is speed.
      roll_rad_ += rate_rad_s * 0.005;
      position_m_[0] += speed_m_s * 0.005 * cosine(roll_rad_);
      position_m_[1] += speed_m_s * 0.005 * sine(roll_rad_);
      PoseSample pose;
      pose.t_us = t;
      pose.position_m[0] = position_m_[0];
      pose.position_m[1] = position_m_[1];
      pose.orientation_xyzw[2] = sine(roll_rad_ / 2);
      pose.orientation_xyzw[3] = cosine(roll_rad_ / 2);
      engine_->inlets().push({&pose, 1});
    }
    REQUIRE(engine_->tick());
    DepthFrame frame;
    REQUIRE(engine_->newest(frame));
    return frame;
  }
  [[nodiscard]] Health health() { return engine_->health(); }

 private:
  SlidingScene scene_;
  EngineInBlock engine_;
  double roll_rad_ = 0;
  double position_m_[2] = {0, 0};
};

std::size_t known(const DepthFrame& frame) {
  return frame.confidence.size() -
         static_cast<std::size_t>(std::count(frame.confidence.begin(), frame.confidence.end(), 0));
}

double mean_confidence(const DepthFrame& frame) {
  double sum = 0;
  for (const std::uint8_t c : frame.confidence) sum += c;
  return sum / static_cast<double>(frame.confidence.size());
}

}  // namespace

TEST_CASE("each limit of carrying has its range") {
  CHECK(checked(0, 0.5, 0.1).ok());
  CHECK(checked(600'000'000, 1, 1).ok());
  CHECK(checked(600'000'000, 0.01, 0).ok());
  CHECK(checked(-1, 0.5, 0.1).code() == StatusCode::kBadCarry);
  CHECK(checked(600'000'001, 0.5, 0.1).code() == StatusCode::kBadCarry);
  CHECK(checked(1, 0.009, 0.1).code() == StatusCode::kBadCarry);
  CHECK(checked(1, 1.001, 0.1).code() == StatusCode::kBadCarry);
  CHECK(checked(1, std::nan(""), 0.1).code() == StatusCode::kBadCarry);
  CHECK(checked(1, 0.5, -0.1).code() == StatusCode::kBadCarry);
  CHECK(checked(1, 0.5, std::nan("")).code() == StatusCode::kBadCarry);
}

TEST_CASE("three bytes per pixel, and none where nothing is carried") {
  Arena on;
  const CarriedDepth carried({}, {346, 260, 226, 226, 173, 130}, {}, on);
  const auto lines = [](std::size_t bytes) { return (bytes + 63) / 64 * 64; };
  constexpr std::size_t pixels = 346 * 260;
  CHECK(on.used_bytes() == lines(2 * pixels) + lines(pixels));
  Arena off;
  CarriedDepth nothing({0, 0.5, 0.1}, kGrid, {}, off);
  CHECK(off.used_bytes() == 0);
  nothing.keep(Frame().frame, 0);
  CHECK_FALSE(nothing.kept());
}

TEST_CASE("at a standstill depth stays as it is, and confidence falls evenly to the end") {
  test::RoomyArena arena;
  const std::span<std::uint32_t> borrowed = landed(*arena);
  CarriedDepth carried({2'000'000, 0.5, 0.1}, kGrid, borrowed, *arena);
  CHECK_FALSE(show(carried, still(0, 0)).any);
  const Frame kept;
  carried.keep(kept.frame, 990'000);
  CHECK(carried.kept());
  CHECK(carried.followed_us() == 1'000'000);
  for (const std::int64_t age_us : {10'000, 500'000, 1'000'000, 1'999'999}) {
    const Shown shown = show(carried, still(1'000'000, 990'000 + age_us));
    REQUIRE(shown.any);
    CHECK(shown.frame.flags == kCarried);
    CHECK(shown.frame.inverse_depth_scale_per_m == 1e-3);
    CHECK(shown.inverse_depth == kept.inverse_depth);
    const double expected = 255 * (1 - static_cast<double>(age_us) / 2e6);
    CHECK(static_cast<double>(shown.confidence[77]) >= expected);
    CHECK(static_cast<double>(shown.confidence[77]) <= expected + 2);
    CHECK(std::count(borrowed.begin(), borrowed.end(), 0u) == kGrid.width_px * kGrid.height_px);
  }
  CHECK(carried.kept());
  CHECK_FALSE(show(carried, still(1'000'000, 2'990'000)).any);
  CHECK_FALSE(carried.kept());
}

TEST_CASE("a frame with less parallax takes the place of a stronger one when that has aged by as much") {
  test::RoomyArena arena;
  CarriedDepth carried({30'000'000, 0.5, 0.1}, kGrid, landed(*arena), *arena);
  Frame strong;
  Frame weak;
  strong.frame.parallax_px = 40;
  weak.frame.parallax_px = 20;
  weak.inverse_depth[0] = 7;
  const auto replaced_after = [&](std::int64_t later_us) {
    carried.drop();
    carried.keep(strong.frame, 1'000'000);
    weak.frame.t_us = strong.frame.t_us + later_us;
    carried.keep(weak.frame, 1'000'000 + later_us);
    return carried.followed_us() == weak.frame.t_us;
  };
  CHECK_FALSE(replaced_after(50'000));
  CHECK_FALSE(replaced_after(990'000));
  CHECK(replaced_after(1'010'000));  // 40 * (1 - 1 / 2) = 20
  CHECK(show(carried, still(2'010'000, 2'010'000)).inverse_depth[0] == 7);
  carried.keep(strong.frame, 2'020'000);  // more parallax: at once
  CHECK(show(carried, still(1'000'000, 2'020'000)).inverse_depth[0] == 100);
}

TEST_CASE("a turn of a hundred steps shows what one step shows: nothing adds up") {
  test::RoomyArena arena;
  CarriedDepth carried({30'000'000, 0.5, 0}, kGrid, landed(*arena), *arena);
  const Frame kept;
  carried.keep(kept.frame, 1'000'000);
  const Shown once = show(carried, moving(1'000'000, 2'000'000, 0.25, 0));
  REQUIRE(once.any);
  for (std::int64_t i = 0; i < 100; ++i) {
    const std::int64_t from_us = 1'000'000 + 10'000 * i;
    // What is only held is shown, and forgotten.
    CHECK(show(carried, moving(from_us, from_us + 30'000, 0.1, 0.01)).any);
    carried.follow(moving(from_us, from_us + 10'000, 0.0025, 0));
  }
  CHECK(carried.followed_us() == 2'000'000);
  const Shown last = show(carried, still(2'000'000, 2'000'000));
  REQUIRE(last.any);
  CHECK(last.inverse_depth == once.inverse_depth);
  CHECK(last.confidence == once.confidence);
}

TEST_CASE("carrying ends out of the picture, comes back with it, and ends where the way is too long") {
  test::RoomyArena arena;
  CarriedDepth carried({30'000'000, 0.5, 0.3}, kGrid, landed(*arena), *arena);
  const Frame kept;  // depths of 1.15 to 10 m
  carried.keep(kept.frame, 1'000'000);
  CHECK(show(carried, moving(1'000'000, 1'100'000, 0.3, 0)).any);  // of 42 degrees
  CHECK_FALSE(show(carried, moving(1'000'000, 1'200'000, 0.6, 0)).any);
  carried.follow(moving(1'000'000, 1'200'000, 0.6, 0));
  CHECK(show(carried, moving(1'200'000, 1'400'000, -0.6, 0)).any);
  carried.follow(moving(1'200'000, 1'400'000, -0.6, 0));
  // Of depths 10 m down to 1.15 m, those beyond twice the way are left: rho < 1 / (2 way). Some leave the
  // picture besides, as it grows.
  double last = 1e9;
  for (const double way_m : {0.1, 0.5, 0.9, 2.0, 3.0}) {
    const Shown shown = show(carried, moving(1'400'000, 1'500'000, 0, way_m));
    const double share = std::min(1.0, (1000 / (2 * way_m) - 100) / kPixels);
    INFO("way " << way_m << ", share of pixels left " << share);
    CHECK(shown.any == (share > 0.3));
    if (!shown.any) continue;
    double sum = 0;
    for (const std::uint8_t c : shown.confidence) sum += c;
    CHECK(sum < last);
    last = sum;
  }
  CHECK_FALSE(show(carried, moving(1'400'000, 1'500'000, 0, 5)).any);
  carried.drop();
  CHECK_FALSE(show(carried, still(1'400'000, 1'500'000)).any);
}

TEST_CASE("a robot that stops goes on seeing what it saw, and says that it does not measure") {
  Walk walk(SlidingScene::config());
  DepthFrame measured;
  for (int i = 0; i < 8; ++i) measured = walk.tick(0.5);
  REQUIRE(measured.flags == 0);
  // The window empties of motion first: those ticks still measure.
  for (int i = 0; (measured.flags & kNoParallax) == 0; ++i) {
    REQUIRE(i < 6);
    measured = walk.tick(0);
  }
  REQUIRE(measured.flags == (kNoParallax | kCarried));
  double confidence = mean_confidence(measured);
  const std::size_t known_px = known(measured);
  const std::vector<std::uint16_t> depth(measured.inverse_depth.begin(), measured.inverse_depth.end());
  const std::int64_t age_us = measured.age_us;
  CHECK(age_us > 0);
  CHECK(known_px > 64 * 48 / 2);
  for (int i = 1; i <= 40; ++i) {
    const DepthFrame frame = walk.tick(0);
    CHECK(frame.flags == (kNoParallax | kCarried));
    CHECK(frame.hypotheses == 0);
    CHECK(frame.events == 0);
    CHECK(frame.votes == 0);
    CHECK(frame.age_us == age_us + i * kPeriod_us);
    CHECK(known(frame) == known_px);
    CHECK(std::equal(depth.begin(), depth.end(), frame.inverse_depth.begin()));
  }
  const DepthFrame old = walk.tick(0);
  CHECK(mean_confidence(old) < confidence * 0.97);
  CHECK(mean_confidence(old) > confidence * 0.9);
  const Health health = walk.health();
  CHECK(health.state == RunState::kDegraded);
  CHECK(health.cause == Cause::kNoParallax);
  CHECK(health.ticks.carried == 42);
  CHECK(health.ticks.no_parallax == 43);  // and the first, of one pose
}

TEST_CASE("a robot that stops and turns about its optical axis sees its depth turn with it") {
  Walk walk(SlidingScene::config());
  for (int i = 0; i < 8; ++i) walk.tick(0.5);
  DepthFrame frame;
  for (int i = 0; i < 6; ++i) frame = walk.tick(0);
  REQUIRE((frame.flags & kCarried) != 0);
  const std::vector<std::uint16_t> before(frame.inverse_depth.begin(), frame.inverse_depth.end());
  const std::vector<std::uint8_t> sure(frame.confidence.begin(), frame.confidence.end());
  // Half a turn in 80 ticks: pixel (x, y) comes to lie at (63 - x, 47 - y), since the centre is (31.5, 23.5).
  for (int i = 0; i < 80; ++i) frame = walk.tick(0, 3.14159265358979 / 80 / 0.05);
  REQUIRE(frame.flags == (kNoParallax | kCarried));
  std::size_t equal = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const std::size_t opposite = before.size() - 1 - i;
    equal +=
        frame.inverse_depth[opposite] == before[i] && (frame.confidence[opposite] != 0) == (sure[i] != 0);
  }
  CHECK(equal == before.size());
}

TEST_CASE("too few events: carried as long as a frame with enough is kept; else measured") {
  Config config = SlidingScene::config();
  config.window.min_events = 600;  // of 500 per tick and 2000 in the window
  Walk walk(config);
  CHECK((walk.tick(0.5).flags & kCarried) == 0);
  DepthFrame frame = walk.tick(0.5);
  for (int i = 0; i < 6; ++i) frame = walk.tick(0.5);
  CHECK(frame.flags == 0);
  std::uint32_t seen_flags = 0;
  for (int i = 0; i < 4; ++i) {
    frame = walk.tick(0.5, 0, false);
    seen_flags |= frame.flags;
    if (frame.flags & kTooFewEvents) CHECK((frame.flags & kCarried) != 0);
  }
  CHECK(seen_flags == (kTooFewEvents | kCarried));
  CHECK(walk.health().state == RunState::kDegraded);
  CHECK(walk.health().cause == Cause::kTooFewEvents);
  config.carry.max_age_us = 0;
  Walk without(config);
  for (int i = 0; i < 8; ++i) without.tick(0.5);
  for (int i = 0; i < 3; ++i) frame = without.tick(0.5, 0, false);
  CHECK((frame.flags & kCarried) == 0);
  CHECK((frame.flags & kTooFewEvents) != 0);
}

TEST_CASE("switched off, a standstill is blank as ever") {
  Config config = SlidingScene::config();
  config.carry.max_age_us = 0;
  Walk walk(config);
  for (int i = 0; i < 8; ++i) walk.tick(0.5);
  DepthFrame frame;
  for (int i = 0; i < 8; ++i) frame = walk.tick(0);
  CHECK(frame.flags == kNoParallax);
  CHECK(known(frame) == 0);
  CHECK(frame.inverse_depth_scale_per_m == 0);
  CHECK(walk.health().state == RunState::kStalled);
}

TEST_CASE("carried bytes are the same for any number of threads, and from run to run") {
  std::uint64_t hash[4];
  for (const int i : {0, 1, 2, 3}) {
    Config config = SlidingScene::config();
    config.threads = i == 0 ? 1 : i;
    Walk walk(config);
    test::FrameHash sum;
    for (int tick = 0; tick < 20; ++tick) sum.add(walk.tick(tick < 8 ? 0.5 : 0.02, tick < 8 ? 0 : 0.4));
    hash[i] = sum.value();
    CHECK(walk.health().ticks.carried > 5);
  }
  for (const int i : {1, 2, 3}) CHECK(hash[i] == hash[0]);
  INFO(std::hex << hash[0]);
  CHECK(hash[0] == 0xa3b9b2ccffe47c64u);
}
