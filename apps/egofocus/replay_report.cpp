#include "replay_report.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "percentiles_json.hpp"

namespace egofocus::app {
namespace {

constexpr std::uint64_t kFnvOffset = 14695981039346656037ull;
constexpr std::uint64_t kFnvPrime = 1099511628211ull;

// Values enter byte by byte, lowest first: the same on any byte order.
void mix(std::uint64_t& hash, std::uint64_t value, int bytes) noexcept {
  for (int i = 0; i < bytes; ++i) hash = (hash ^ ((value >> (8 * i)) & 0xff)) * kFnvPrime;
}

std::uint64_t bits_of(double value) noexcept {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

std::size_t known_pixels(const DepthFrame& frame) {
  return static_cast<std::size_t>(
      std::count_if(frame.confidence.begin(), frame.confidence.end(), [](std::uint8_t c) { return c != 0; }));
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

// Means, in milliseconds.
Json stage_facts(const std::vector<StageTimes>& stages) {
  const auto mean_ms = [&stages](std::uint32_t StageTimes::*stage) {
    double sum_us = 0;
    for (const StageTimes& times : stages) sum_us += times.*stage;
    return sum_us / 1000.0 / static_cast<double>(stages.size());
  };
  return Json()
      .add("motion", mean_ms(&StageTimes::motion_us))
      .add("warp", mean_ms(&StageTimes::warp_us))
      .add("input", mean_ms(&StageTimes::input_us))
      .add("backend", mean_ms(&StageTimes::backend_us))
      .add("depth", mean_ms(&StageTimes::depth_us));
}

Json arena_facts(const ArenaBytes& bytes) {
  return Json()
      .add("all", bytes.all)
      .add("engine", bytes.engine)
      .add("rings", bytes.rings)
      .add("window", bytes.window)
      .add("motion", bytes.motion)
      .add("warp", bytes.warp)
      .add("backend", bytes.backend)
      .add("weights", bytes.weights)
      .add("depth", bytes.depth);
}

Json event_facts(const Health& health) {
  const EventCounters& e = health.events;
  Json facts;
  facts.add("in", e.in).add("kept", e.kept).add("ring_dropped", e.ring_dropped);
  if (e.over_rate > 0) facts.add("over_rate", e.over_rate);  // where a limit is set
  return facts.add("out_of_range", e.out_of_range)
      .add("out_of_order", e.out_of_order)
      .add("late", e.late)
      .add("ahead", e.ahead)
      .add("hot_pixel", e.hot_pixel)
      .add("refractory", e.refractory)
      .add("isolated", e.isolated)
      .add("outside_motion", health.window.outside_motion)
      .add("decimated", health.window.decimated);
}

Json sample_facts(const SampleCounters& c) {
  return Json()
      .add("in", c.in)
      .add("used", c.used)
      .add("ring_dropped", c.ring_dropped)
      .add("late", c.late)
      .add("invalid", c.invalid)
      .add("rejected", c.rejected);
}

Json tick_facts(const TickCounters& t) {
  return Json()
      .add("run", t.run)
      .add("no_parallax", t.no_parallax)
      .add("too_few_events", t.too_few_events)
      .add("stale_velocity", t.stale_velocity)
      .add("no_motion", t.no_motion)
      .add("carried", t.carried);
}

Json file_facts(const recording::Replay& replay) {
  const ReplayCounters c = replay.counters();
  std::uint64_t violations = 0;
  for (const std::uint64_t count : c.events.violations) violations += count;
  return Json()
      .add("cut_off_bytes", replay.cut_off_bytes())
      .add("event_stream_violations", violations)
      .add("events_dropped_in_decoding", c.events.dropped_events)
      .add("can_lines_unknown", c.can_log.unknown + c.can_log.over_long)
      .add("can_frames", c.can_motion.frames)
      .add("can_frames_unknown", c.can_motion.frames_unknown)
      .add("can_samples_invalid", c.can_motion.samples_invalid)
      .add("can_samples_incomplete", c.can_motion.samples_incomplete)
      .add("pose_lines_unusable", c.poses.malformed + c.poses.bad_quaternion + c.poses.over_long);
}

Json health_facts(recording::Replay& replay) {
  const Health health = replay.engine().health();
  return Json()
      .add("state", to_string(health.state))
      .add("cause", to_string(health.cause))
      .add("events", event_facts(health))
      .add("imu", sample_facts(health.imu))
      .add("odometry", sample_facts(health.odometry))
      .add("poses", sample_facts(health.poses))
      .add("ticks", tick_facts(health.ticks))
      .add("sources_lost", health.sources_lost)
      .add("files", file_facts(replay));
}

std::string hash_text(std::uint64_t hash) {
  char text[20];
  std::snprintf(text, sizeof text, "%016" PRIx64, hash);
  return text;
}

}  // namespace

std::uint64_t frame_hash(const DepthFrame& frame) noexcept {
  std::uint64_t hash = kFnvOffset;
  for (const std::uint16_t v : frame.inverse_depth) mix(hash, v, 2);
  for (const std::uint8_t v : frame.confidence) mix(hash, v, 1);
  mix(hash, bits_of(frame.inverse_depth_scale_per_m), 8);
  mix(hash, bits_of(frame.parallax_px), 8);
  for (const double v : frame.velocity_m_s) mix(hash, bits_of(v), 8);
  for (const double v : frame.angular_rate_rad_s) mix(hash, bits_of(v), 8);
  mix(hash, frame.flags, 4);
  mix(hash, frame.events, 4);
  mix(hash, frame.votes, 8);
  mix(hash, static_cast<std::uint64_t>(frame.t_us), 8);
  mix(hash, static_cast<std::uint64_t>(frame.age_us), 8);
  return hash;
}

std::string flags_text(std::uint32_t flags) {
  constexpr const char* kNames[] = {"no_parallax", "too_few_events", "stale_velocity", "no_motion",
                                    "overload",    "late_tick",      "carried"};
  std::string text;
  for (std::size_t i = 0; i < std::size(kNames); ++i) {
    if (flags & (1u << i)) text += (text.empty() ? "" : "+") + std::string(kNames[i]);
  }
  return text.empty() ? "none" : text;
}

void ReplayReport::add(const DepthFrame& frame, double milliseconds) {
  const std::uint64_t hash = frame_hash(frame);
  if (ticks() == 0) {
    first_us_ = frame.t_us;
    hash_ = kFnvOffset;
  }
  mix(hash_, hash, 8);
  last_us_ = frame.t_us;
  const std::size_t known = known_pixels(frame);
  char line[200];
  std::snprintf(line, sizeof line,
                "tick %3" PRIu64 " t_us %9" PRId64 " events %6u votes %9" PRIu64
                " known_px %6zu hash %s flags %s",
                frame.sequence, frame.t_us, frame.events, frame.votes, known, hash_text(hash).c_str(),
                flags_text(frame.flags).c_str());
  lines_.emplace_back(line);
  times_.add(frame, milliseconds);
  events_ += frame.events;
  votes_ += frame.votes;
  if (known > 0) {
    ++with_depth_;
    coverage_.push_back(static_cast<double>(known) / static_cast<double>(frame.confidence.size()));
  }
}

void ReplayReport::add_stages(const StageTimes& stages) {
  stages_.push_back(stages);
}

void ReplayReport::add_truth(const recording::DepthError& error) {
  if (error.compared_px > 0) errors_.push_back(error);
}

std::string ReplayReport::golden_text(recording::Replay& replay) const {
  std::string text;
  for (const std::string& line : lines_) text += line + "\n";
  text += "hash " + hash_text(hash_) + "\n" + health_facts(replay).text() + "\n";
  return text;
}

Json ReplayReport::summary(recording::Replay& replay, const ReplayReport* beside) const {
  const double span_s = static_cast<double>(replay.last_event_us() - replay.first_event_us()) * 1e-6;
  Json facts;
  facts.add("recording", replay.folder().path.string())
      .add("backend", replay.config().backend == Backend::kNetwork ? "network" : "focus")
      .add("isa", replay.engine().isa())
      .add("threads", replay.config().threads)
      .add("arena_bytes", arena_facts(replay.arena_bytes()))
      .add("ticks", ticks())
      .add("ticks_with_depth", with_depth_)
      .add("first_tick_us", first_us_)
      .add("last_tick_us", last_us_)
      .add("events_per_second", span_s > 0 ? static_cast<double>(replay.event_count()) / span_s : 0.0)
      .add("votes", votes_);
  add_findings(facts);
  if (beside != nullptr) {
    Json other;
    beside->add_findings(other);
    facts.add("focus", other);
  }
  facts.add("health", health_facts(replay)).add("hash", hash_text(hash_));
  return facts;
}

void ReplayReport::add_findings(Json& facts) const {
  facts.add("coverage", mean(coverage_))
      .add("tick_ms", percentiles_json(times_.tick_ms()))
      .add("event_to_depth_ms", percentiles_json(times_.event_to_depth_ms()));
  if (!stages_.empty()) facts.add("stage_ms", stage_facts(stages_));
  if (!errors_.empty()) {
    std::vector<double> median;
    std::vector<double> within;
    std::vector<double> d1;
    std::vector<double> abs_rel;
    for (const recording::DepthError& e : errors_) {
      median.push_back(e.median);
      within.push_back(e.within_10_percent);
      d1.push_back(e.d1);
      abs_rel.push_back(e.abs_rel);
    }
    facts.add("accuracy", Json()
                              .add("frames", errors_.size())
                              .add("median_relative_error", mean(median))
                              .add("abs_rel", mean(abs_rel))
                              .add("within_10_percent", mean(within))
                              .add("d1", mean(d1)));
  }
}

}  // namespace egofocus::app
