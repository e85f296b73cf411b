// A day of sensor time under the virtual clock: a minute of driving, again and again, one tick a second. Each
// event goes through every camera format's encoder and real decoder and must come back as it was, over all
// wraps of their time stamps; the engine gets them from another format each minute. Each minute must give the
// same depth bytes, and memory must stay as it is. A camera's clock that drifts is mapped all the while.
// usage: soak [--hours H]
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>

#include "event_streams.hpp"
#include "hal/clock_map.hpp"
#include "recording/json.hpp"
#include "resident_memory.hpp"
#include "support/engine_in_block.hpp"
#include "support/frame_hash.hpp"
#include "support/sliding_scene.hpp"

namespace egofocus::reliability {
namespace {

using test::SlidingScene;

constexpr std::int64_t kSecond_us = 1'000'000;
constexpr int kCycle_s = 60;
constexpr int kDriven_s = 58;    // the rest of the minute is silent: motion and window begin anew
constexpr int kEveryEvent = 10;  // of the scene's: 1,000 a second
constexpr double kGravity_m_s2 = 9.80665;
constexpr double kMostGrowth_percent = 1;
constexpr std::int64_t kMostClockError_us = 300;

// What one cycle is made of, second by second, from time 0 on.
struct Drive {
  std::vector<Event> events[kCycle_s];
  std::vector<ImuSample> imu[kCycle_s];
  std::vector<OdometrySample> odometry[kCycle_s];

  Drive() {
    const SlidingScene scene;
    for (int s = 0; s < kDriven_s; ++s) {
      const std::int64_t from_us = s * kSecond_us;
      const std::vector<Event> all = scene.events(from_us, from_us + kSecond_us);
      for (std::size_t i = 0; i < all.size(); i += kEveryEvent) events[s].push_back(all[i]);
      imu[s] = SlidingScene::imu(from_us, from_us + kSecond_us);
      // Exactly what the filter expects at rest: else biases go on converging for hours, each minute a
      // little.
      for (ImuSample& sample : imu[s]) sample.accel_m_s2[2] = kGravity_m_s2;
      odometry[s] = SlidingScene::odometry(from_us, from_us + kSecond_us);
    }
  }
};

template <typename Sample>
std::vector<Sample> later(std::vector<Sample> samples, std::int64_t us) {
  for (Sample& sample : samples) sample.t_us += us;
  return samples;
}

// 50 ppm fast, seen through up to 5 ms of delay, a hundred times a second.
class DriftingClock {
 public:
  void pass_second(std::int64_t until_us) {
    for (std::int64_t t_us = until_us - kSecond_us; t_us < until_us; t_us += kSecond_us / 100) {
      const std::int64_t device_us = t_us + t_us / 20'000;
      map_.observe(device_us, t_us + std::uniform_int_distribution<std::int64_t>(0, 5'000)(random_));
      const std::int64_t error_us = std::abs(map_.to_host_us(device_us) - t_us);
      if (t_us > 10 * kSecond_us && error_us > worst_us_) worst_us_ = error_us;
    }
  }
  [[nodiscard]] std::int64_t worst_us() const noexcept { return worst_us_; }

 private:
  ClockMap map_;
  std::mt19937 random_{3};
  std::int64_t worst_us_ = 0;
};

Config soak_config() {
  Config config = SlidingScene::config();
  config.motion.source = MotionSource::kOdometry;
  config.rate.rate_hz = 1;
  config.window.max_age_us = kSecond_us;
  config.rings.imu = config.rings.odometry = 1u << 9;
  return config;
}

class Soak {
 public:
  /// False: this cycle was not as the others.
  bool run_cycle(int cycle) {
    const std::int64_t begin_us = cycle * kCycle_s * kSecond_us;
    test::FrameHash hash;
    for (int s = 0; s < kCycle_s; ++s) {
      const std::vector<Event> events = later(drive_.events[s], begin_us);
      for (int format = 0; format < EventStreams::kCount; ++format) {
        const std::span<const Event> decoded = streams_.pass(format, events);
        if (!same(decoded, events)) ++wrong_[format];
        if (format == cycle % EventStreams::kCount) engine_->inlets().push(decoded);
      }
      events_ += events.size();
      engine_->inlets().push(later(drive_.imu[s], begin_us));
      engine_->inlets().push(later(drive_.odometry[s], begin_us));
      clock_.pass_second(begin_us + (s + 1) * kSecond_us);
      DepthFrame frame;
      if (!engine_->tick() || !engine_->newest(frame)) return false;
      frames_with_depth_ += frame.votes > 0 ? 1 : 0;
      frame.t_us -= begin_us;
      frame.sequence = 0;
      hash.add(frame);
    }
    hash_ = hash.value();
    return true;
  }

  [[nodiscard]] std::uint64_t hash() const noexcept { return hash_; }
  [[nodiscard]] std::int64_t clock_error_us() const noexcept { return clock_.worst_us(); }
  [[nodiscard]] std::uint64_t frames_with_depth() const noexcept { return frames_with_depth_; }
  [[nodiscard]] std::uint64_t events() const noexcept { return events_; }
  /// Seconds whose events came back otherwise, and what the decoder complained of.
  [[nodiscard]] std::uint64_t wrong(int format) { return wrong_[format] + streams_.violations(format); }
  [[nodiscard]] Health health() noexcept { return engine_->health(); }
  [[nodiscard]] bool start() {
    return engine_.status.ok() && engine_->start(ClockKind::kVirtual, kSecond_us).ok();
  }

 private:
  Drive drive_;
  EventStreams streams_{{SlidingScene::kWidth, SlidingScene::kHeight}};
  DriftingClock clock_;
  test::EngineInBlock engine_{soak_config()};
  std::uint64_t wrong_[EventStreams::kCount] = {};
  std::uint64_t frames_with_depth_ = 0;
  std::uint64_t events_ = 0;
  std::uint64_t hash_ = 0;
};

int run(double hours) {
  const int cycles = static_cast<int>(hours * 3600 / kCycle_s);
  make_program_resident();
  Soak soak;
  if (cycles < 4 || !soak.start()) {
    std::fprintf(stderr, "soak: needs --hours of at least %.3f\n", 4.0 * kCycle_s / 3600);
    return 2;
  }
  std::uint64_t first_hash = 0;
  std::int64_t first_rss = 0;
  int different = 0;
  for (int cycle = 0; cycle < cycles; ++cycle) {
    if (!soak.run_cycle(cycle)) ++different;
    if (cycle == 1) {  // the first begins without a bias that is known, and with memory never touched
      first_hash = soak.hash();
      first_rss = resident_bytes();
    }
    if (cycle > 1 && soak.hash() != first_hash) ++different;
  }
  const double growth_percent =
      100.0 * static_cast<double>(resident_bytes() - first_rss) / static_cast<double>(first_rss);

  char hash[20];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(first_hash));
  recording::Json json;
  const double sensor_s = static_cast<double>(cycles) * kCycle_s;
  json.add("sensor_hours", sensor_s / 3600).add("ticks", soak.health().ticks.run);
  json.add("ticks_with_depth", soak.frames_with_depth()).add("events", soak.events());
  json.add("cycles", cycles).add("cycles_different", different).add("hash", hash);
  std::uint64_t wrong = 0;
  for (int format = 0; format < EventStreams::kCount; ++format) {
    const EventStreams::Format& f = EventStreams::kFormats[static_cast<std::size_t>(format)];
    json.add(std::string("wraps_") + f.name, static_cast<std::int64_t>(sensor_s * 1e6) >> f.wrap_bits);
    json.add(std::string("wrong_") + f.name, soak.wrong(format));
    wrong += soak.wrong(format);
  }
  json.add("clock_error_us", soak.clock_error_us()).add("resident_kib", resident_bytes() / 1024);
  json.add("resident_growth_percent", growth_percent);
  std::puts(json.json().c_str());

  const Health health = soak.health();
  const bool is_whole = health.events.kept == soak.events();
  const bool is_deep = soak.frames_with_depth() >= static_cast<std::uint64_t>(cycles) * (kDriven_s - 2);
  const bool is_steady = !EGOFOCUS_RESIDENT_MEMORY_IS_OURS || growth_percent < kMostGrowth_percent;
  return different == 0 && wrong == 0 && is_whole && is_deep && is_steady &&
                 soak.clock_error_us() <= kMostClockError_us
             ? 0
             : 1;
}

}  // namespace
}  // namespace egofocus::reliability

int main(int argc, char** argv) {
  double hours = 24;
  if (argc == 3 && std::strcmp(argv[1], "--hours") == 0) {
    hours = std::atof(argv[2]);
  } else if (argc != 1) {
    std::fprintf(stderr, "usage: soak [--hours H]\n");
    return 2;
  }
  return egofocus::reliability::run(hours);
}
