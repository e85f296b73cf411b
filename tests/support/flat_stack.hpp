// A Warp whose stack of images a test lays down event by event: camera and grid are the same pinhole, and
// each event's landing line is chosen through the time at which it happened.
//
// The motion is a slide to the right at constant speed, so an event at share s of the window moves left by
// (1 - s) * span * k / (D - 1) pixels under hypothesis k: exact geometry, no approximation.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "pipeline/warp.hpp"
#include "support/arena_block.hpp"

namespace egofocus::test {

class FlatStack {
 public:
  static constexpr std::int64_t kLength_us = 100'000;
  /// Sign of u's shift under a positive hypothesis: the camera slides right, and where it was lies to the
  /// left.
  static constexpr double kDirection = -1;

  FlatStack(std::int32_t width, std::int32_t height, std::int32_t hypotheses, double span_px,
            const std::vector<Event>& events)
      : arena_(std::size_t{1} << 26) {
    config.camera.intrinsics = {width, height, 100, 100, 0.5 * width, 0.5 * height};
    config.ladder.hypotheses = hypotheses;
    config.window.max_events = std::max(100, static_cast<int>(events.size()));
    config.window.min_events = 0;
    MotionSample slide;
    slide.velocity_m_s[0] = 1;
    integrate_track({&slide, 1}, 0, kLength_us, track_);
    ladder_.count = hypotheses;
    ladder_.step_per_m = span_px / (hypotheses - 1) / (100 * 0.1);  // f * distance
    window_ = std::make_unique<EventWindow>(config.window, config.camera.intrinsics, *arena_);
    warp = std::make_unique<Warp>(config, select_kernels(isa_bit(Isa::kScalar)), *arena_);
    warp->prepare(config.camera);
    for (const Event& e : events) window_->add(e);
    warp->project(*window_, window_->select(0, kLength_us), track_, ladder_, 0, 1);
    warp->vote(0, 1);
  }

  Config config;
  std::unique_ptr<Warp> warp;

 private:
  RoomyArena arena_;
  MotionTrack track_;
  HypothesisLadder ladder_;
  std::unique_ptr<EventWindow> window_;
};

}  // namespace egofocus::test
