// The network backend on stacks that it never saw in training: saturated, empty, without parallax. Depth is
// flagged, or missing; nothing crashes and nothing is divided by zero (the sanitizers' builds look).
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "support/engine_in_block.hpp"
#include "support/network_vectors.hpp"
#include "support/sliding_scene.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using test::SlidingScene;

namespace {

constexpr std::int64_t kTick_us = 100'000;

/// One tick of the sliding camera, with whatever events.
class OneTick {
 public:
  OneTick() : model_(test::file_bytes(test::source_dir() + "/fixtures/network/model.efm")) {
    config.backend = Backend::kNetwork;
    config.model = model_.bytes();
    config.rings.events = 1u << 18;
  }

  DepthFrame run(const std::vector<Event>& events, double speed_m_s = SlidingScene::kSpeed_m_s) {
    engine_ = std::make_unique<test::EngineInBlock>(config);
    REQUIRE(engine_->status.ok());
    test::EngineInBlock& engine = *engine_;
    REQUIRE(engine->start(ClockKind::kVirtual, kTick_us).ok());
    std::vector<PoseSample> poses = SlidingScene::poses(0, kTick_us);
    for (PoseSample& pose : poses) pose.position_m[0] *= speed_m_s / SlidingScene::kSpeed_m_s;
    engine->inlets().push(poses);
    engine->inlets().push(events);
    REQUIRE(engine->tick());
    DepthFrame frame;
    REQUIRE(engine->newest(frame));
    for (std::size_t i = 0; i < frame.inverse_depth.size(); ++i) {
      const int most = frame.hypotheses > 0 ? 256 * (frame.hypotheses - 1) : 0;
      REQUIRE(frame.inverse_depth[i] <= most);
    }
    return frame;
  }

  Config config = SlidingScene::config();

 private:
  test::ModelMemory model_;
  std::unique_ptr<test::EngineInBlock> engine_;
};

/// n events, the last of them at the tick, each at its place.
template <class Place>
std::vector<Event> events_at(int n, Place place) {
  std::vector<Event> events;
  for (int i = 0; i < n; ++i) {
    Event event = place(i);
    event.t_us = kTick_us - 40'000 + 40'000 * std::int64_t{i} / n + 1;
    event.polarity = static_cast<std::uint8_t>(i & 1);
    events.push_back(event);
  }
  return events;
}

bool is_blank(const DepthFrame& frame) {
  for (const std::uint8_t c : frame.confidence) {
    if (c != 0) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("saturated stacks give depth with the flag of an overload, or none") {
  OneTick tick;
  // 80,000 events on 16x16 pixels: every count of theirs ends at 255.
  const DepthFrame block = tick.run(events_at(90'000, [](int i) {
    return Event{0, static_cast<std::uint16_t>(20 + i % 16), static_cast<std::uint16_t>(10 + i / 16 % 16), 0};
  }));
  CHECK((block.flags & kOverload) != 0);
  CHECK(block.events == 80'000);
  CHECK(block.hypotheses > 0);
  // One pixel alone.
  const DepthFrame pixel = tick.run(events_at(60'000, [](int) { return Event{0, 31, 23, 0}; }));
  CHECK(pixel.flags == 0);
  CHECK(pixel.hypotheses > 0);
  // Everywhere alike: nothing is sharper than anything else.
  const DepthFrame even = tick.run(events_at(64 * 48 * 20, [](int i) {
    return Event{0, static_cast<std::uint16_t>(i % 64), static_cast<std::uint16_t>(i / 64 % 48), 0};
  }));
  CHECK(even.flags == 0);
}

TEST_CASE("empty stacks are flagged: without an event no depth, with one a poor one") {
  OneTick tick;
  const DepthFrame nothing = tick.run({});
  CHECK(nothing.flags == kTooFewEvents);
  CHECK(nothing.hypotheses == 0);
  CHECK(is_blank(nothing));
  const DepthFrame one = tick.run(events_at(1, [](int) { return Event{0, 5, 7, 1}; }));
  CHECK(one.flags == kTooFewEvents);
  CHECK(one.events == 1);
}

TEST_CASE("events that fall beside the grid leave the stack empty, and the frame without votes") {
  OneTick tick;
  tick.config.grid = {64, 48, 400, 400, 31.5, 23.5};  // a narrow view of the same axis
  const DepthFrame frame = tick.run(events_at(2000, [](int i) {
    return Event{0, static_cast<std::uint16_t>(i % 2), static_cast<std::uint16_t>(i % 3), 0};
  }));
  CHECK(frame.votes == 0);
  CHECK(frame.events == 2000);
  CHECK(frame.hypotheses > 0);
}

TEST_CASE("a ladder without parallax: no depth, and the frame says why") {
  OneTick tick;
  const auto events = SlidingScene().events(0, kTick_us);
  const DepthFrame still = tick.run(events, 0);
  CHECK(still.flags == kNoParallax);
  CHECK(still.hypotheses == 0);
  CHECK(is_blank(still));
  const DepthFrame creeping = tick.run(events, 1e-9);
  CHECK(creeping.flags == kNoParallax);
  // Hardly any parallax, and a model that asks for more of it.
  const DepthFrame slow = tick.run(events, 0.02);
  CHECK((slow.flags & kNoParallax) != 0);
  CHECK(is_blank(slow));
}
