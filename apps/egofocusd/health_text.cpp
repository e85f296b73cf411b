#include "health_text.hpp"

#include <string_view>

#include "egofocus/version.hpp"
#include "recording/json.hpp"

namespace egofocus::daemon {
namespace {

class Teller {
 public:
  // Only ever grows.
  void count(const std::string& name, std::uint64_t value) {
    json_.add(name, value);
    line(name + "_total", "counter", "", std::to_string(value));
  }
  void gauge(const std::string& name, std::uint64_t value) {
    json_.add(name, value);
    line(name, "gauge", "", std::to_string(value));
  }
  // A text that changes seldom: a label of a line that is always 1.
  void text(const std::string& name, std::string_view value) {
    json_.add(name, value);
    line(name, "gauge", "{" + name + "=" + recording::json_text(value) + "}", "1");
  }
  // For JSON alone.
  void remark(const std::string& name, std::string_view value) { json_.add(name, value); }

  [[nodiscard]] HealthText told() const { return {json_.json(), metrics_}; }

 private:
  void line(const std::string& name, const char* type, const std::string& labels, const std::string& value) {
    metrics_ += "# TYPE egofocus_" + name + " " + type + "\negofocus_" + name + labels + " " + value + "\n";
  }
  recording::Json json_;
  std::string metrics_;
};

void tell(Teller& t, const EventCounters& c) {
  const auto& [in, ring_dropped, over_rate, out_of_range, out_of_order, ahead, late, hot_pixel, refractory,
               isolated, kept] = c;
  t.count("events_in", in);
  t.count("events_ring_dropped", ring_dropped);
  t.count("events_over_rate", over_rate);
  t.count("events_out_of_range", out_of_range);
  t.count("events_out_of_order", out_of_order);
  t.count("events_ahead", ahead);
  t.count("events_late", late);
  t.count("events_hot_pixel", hot_pixel);
  t.count("events_refractory", refractory);
  t.count("events_isolated", isolated);
  t.count("events_kept", kept);
}

void tell(Teller& t, const std::string& kind, const SampleCounters& c) {
  const auto& [in, ring_dropped, late, invalid, used, rejected] = c;
  t.count(kind + "_in", in);
  t.count(kind + "_ring_dropped", ring_dropped);
  t.count(kind + "_late", late);
  t.count(kind + "_invalid", invalid);
  t.count(kind + "_used", used);
  t.count(kind + "_rejected", rejected);
}

void tell(Teller& t, const WindowCounters& c) {
  const auto& [outside_motion, decimated, behind_camera] = c;
  t.count("window_outside_motion", outside_motion);
  t.count("window_decimated", decimated);
  t.count("window_behind_camera", behind_camera);
}

void tell(Teller& t, const TickCounters& c) {
  const auto& [run, late, skipped, no_parallax, too_few_events, stale_velocity, no_motion, carried] = c;
  t.count("ticks_run", run);
  t.count("ticks_late", late);
  t.count("ticks_skipped", skipped);
  t.count("ticks_no_parallax", no_parallax);
  t.count("ticks_too_few_events", too_few_events);
  t.count("ticks_stale_velocity", stale_velocity);
  t.count("ticks_no_motion", no_motion);
  t.count("ticks_carried", carried);
}

void tell(Teller& t, const StageTimes& s) {
  const auto& [motion_us, warp_us, input_us, backend_us, depth_us, all_us] = s;
  t.gauge("stage_motion_us", motion_us);
  t.gauge("stage_warp_us", warp_us);
  t.gauge("stage_input_us", input_us);
  t.gauge("stage_backend_us", backend_us);
  t.gauge("stage_depth_us", depth_us);
  t.gauge("stage_all_us", all_us);
}

void tell(Teller& t, const RecorderFacts& r) {
  t.gauge("recording", r.on ? 1 : 0);
  t.remark("recording_folder", r.folder);
  t.remark("recording_failure", r.failure);
  t.gauge("recording_bytes", r.bytes);
  t.gauge("recording_events_not_encodable", r.not_encodable);
  t.count("recorder_events_dropped", r.events_dropped);
  t.count("recorder_frames_dropped", r.frames_dropped);
}

}  // namespace

HealthText health_text(const DaemonFacts& facts) {
  const auto& [state, cause, events, imu, odometry, poses, window, ticks, stages, refused, sources_lost] =
      facts.health;
  Teller t;
  t.text("version", EGOFOCUS_VERSION);
  t.text("state", to_string(state));
  t.text("cause", to_string(cause));
  t.text("isa", facts.isa);
  t.gauge("up_s", static_cast<std::uint64_t>(facts.up_s));
  t.gauge("readers", facts.readers);
  t.gauge("sources_lost", sources_lost);
  t.gauge("refused", refused);
  tell(t, events);
  tell(t, "imu", imu);
  tell(t, "odometry", odometry);
  tell(t, "poses", poses);
  tell(t, window);
  tell(t, ticks);
  tell(t, stages);
  tell(t, facts.recorder);
  for (const DeviceFact& fact : facts.devices)
    fact.is_counter ? t.count(fact.name, fact.value) : t.gauge(fact.name, fact.value);
  t.count("reloads", facts.reloads);
  t.count("reloads_failed", facts.reloads_failed);
  t.count("log_lines_left_out", facts.log_lines_left_out);
  return t.told();
}

}  // namespace egofocus::daemon
