// More than the engine was made for.
#include "trial.hpp"

namespace egofocus::reliability {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;

Row overload() {
  Config config = Robot::engine_config();
  config.rings.max_event_rate_hz = 10'000;
  Robot robot(config);
  Trial trial("5x overload", "each event five times, 60 s, at max_event_rate_hz = 10000", robot);
  robot.trouble.event_copies = 5;
  robot.run(60 * kSecond_us);
  const Seen seen = trial.seen();
  robot.trouble = {};
  trial.over();
  trial.expect((seen.flags & kOverload) != 0 && seen.ticks >= 1'199, "not flagged, or ticks are missing");
  trial.expect(trial.up("events_ring_dropped") == 0 && trial.up("ticks_skipped") == 0, "something queued up");
  trial.expect(trial.up("events_over_rate") > 3 * trial.up("events_kept"), "too little was thinned");
  return trial.row();
}

Row unthinned_overload() {
  Config config = Robot::engine_config();
  config.rings.events = 2'048;
  Robot robot(config);
  Trial trial("5x overload, never thinned", "the same 60 s without max_event_rate_hz, a ring of 2048 events",
              robot);
  robot.trouble.event_copies = 5;
  robot.run(60 * kSecond_us);
  const Seen seen = trial.seen();
  robot.trouble = {};
  trial.over();
  trial.expect((seen.flags & kOverload) != 0 && trial.up("events_ring_dropped") > 0,
               "not flagged, or nothing dropped");
  return trial.row();
}

Row hot_pixels() {
  Config config = Robot::engine_config();
  config.filter.hot_pixel_rate_hz = 500;
  config.filter.hot_pixel_learn_us = 100'000;
  Robot robot(config);
  Trial trial("hot-pixel storm",
              "20 pixels at 2 kHz each, 20 s, at hot_pixel_rate_hz = 500, hot_pixel_learn_us = 100000",
              robot);
  robot.trouble.hot_pixels = 20;
  robot.run(20 * kSecond_us);
  trial.over();  // it goes on: what counts is that it is masked
  trial.expect(trial.up("events_hot_pixel") > 0, "no pixel was masked");
  return trial.row();
}

}  // namespace

std::vector<Fault> load_faults() {
  return {{"overload", overload}, {"overload_unthinned", unthinned_overload}, {"hot_pixels", hot_pixels}};
}

}  // namespace egofocus::reliability
