#include "daemon_config.hpp"

#include "recording/error.hpp"
#include "recording/text_file.hpp"
#include "recording/toml_reader.hpp"

namespace egofocus::daemon {
namespace {

using recording::Error;
using recording::ExitCode;
using recording::Names;

constexpr Names<EventsFrom, 3> kEventsNames{
    {{"replay", EventsFrom::kReplay}, {"usb", EventsFrom::kUsb}, {"v4l2", EventsFrom::kV4l2}}};
constexpr Names<MotionFrom, 2> kMotionNames{{{"replay", MotionFrom::kReplay}, {"can", MotionFrom::kCan}}};
constexpr Names<ClockKind, 3> kClockNames{
    {{"real", ClockKind::kMonotonic}, {"virtual", ClockKind::kVirtual}, {"device", ClockKind::kDevice}}};
constexpr Names<AtEnd, 2> kAtEndNames{{{"stop", AtEnd::kStop}, {"repeat", AtEnd::kRepeat}}};
constexpr Names<Backend, 2> kBackendNames{{{"network", Backend::kNetwork}, {"focus", Backend::kFocus}}};

bool is_power_of_two(std::uint32_t value) {
  return value != 0 && (value & (value - 1)) == 0;
}

}  // namespace

// Each key once, with what contradicts it. Looked up by the reader through the argument's name space.
template <typename Section>
void describe(Section& s, SourceConfig& v) {
  s.choice("events", v.events, kEventsNames);
  s.choice("motion", v.motion, kMotionNames);
  s.optional("recording", v.recording);
  s.choice("clock", v.clock, kClockNames);
  s.optional("first_tick_us", v.first_tick_us);
  s.choice("at_end", v.at_end, kAtEndNames);
  s.optional("wait_for_reader", v.wait_for_reader);
  const bool is_replay = v.events == EventsFrom::kReplay;
  if (is_replay != (v.motion == MotionFrom::kReplay))
    s.refuse("motion", "and `events` must be both \"replay\", or both live");
  if (is_replay && v.recording.empty())
    s.refuse("recording", "is missing: events = \"replay\" needs the folder of a recording");
  if (!is_replay && !v.recording.empty()) s.refuse("recording", "is for events = \"replay\" alone");
  if (!is_replay && v.clock == ClockKind::kVirtual)
    s.refuse("clock", "cannot be \"virtual\" with devices, which do not wait; \"device\" goes by their time");
  if (is_replay && v.clock == ClockKind::kDevice)
    s.refuse("clock",
             "cannot be \"device\" with events = \"replay\"; \"virtual\" goes by the recording's time");
  if (v.clock != ClockKind::kDevice && v.first_tick_us != 0)
    s.refuse("first_tick_us", "is for clock = \"device\" alone");
  if (v.clock == ClockKind::kVirtual && v.at_end == AtEnd::kRepeat)
    s.refuse("at_end", "cannot be \"repeat\" with clock = \"virtual\", whose time goes one way");
  if (v.clock == ClockKind::kMonotonic && v.wait_for_reader)
    s.refuse("wait_for_reader", "is for clock = \"virtual\" and \"device\" alone: real time does not wait");
}

template <typename Section>
void describe(Section& s, CanConfig& v) {
  std::string name = v.interface_name;
  s.optional("interface", name);
  if (name.empty() || name.size() >= sizeof v.interface_name || name.find_first_of(" \t/") != name.npos)
    s.refuse("interface", "must have 1..15 characters, none of them a space or a slash");
  v.interface_name[name.copy(v.interface_name, name.size())] = '\0';
  s.optional("hardware_time", v.hardware_time);
  s.optional("wait_for_interface", v.wait_for_interface);
  s.optional("restart_after_us", v.restart_after_us);
  s.optional("receive_buffer_bytes", v.receive_buffer_bytes);
  if (v.restart_after_us < 0) s.refuse("restart_after_us", "must not be negative");
  if (v.receive_buffer_bytes < 0) s.refuse("receive_buffer_bytes", "must not be negative");
}

template <typename Section>
void describe(Section& s, EngineConfig& v) {
  s.optional("camera", v.camera);
  s.choice("backend", v.backend, kBackendNames);
  s.optional("model", v.model);
  s.optional("threads", v.threads);
  s.optional("rate_hz", v.rate_hz);
  s.optional("lateness_us", v.lateness_us);
  s.optional("max_late_us", v.max_late_us);
  s.optional("max_event_rate_hz", v.max_event_rate_hz);
  s.optional("fifo_priority", v.real_time.fifo_priority);
  s.optional("cpu", v.real_time.cpu);
  s.optional("lock_memory", v.real_time.lock_memory);
  if (v.backend == Backend::kFocus && !v.model.empty())
    s.refuse("model", "is for backend = \"network\" alone");
}

template <typename Section>
void describe(Section& s, SocketConfig& v) {
  s.optional("socket", v.socket);
  s.optional("group", v.group);
  if (v.socket.empty()) s.refuse("socket", "must not be empty");
}

template <typename Section>
void describe(Section& s, DepthConfig& v) {
  describe(s, static_cast<SocketConfig&>(v));
  s.optional("slots", v.slots);
  if (!is_power_of_two(v.slots) || v.slots < 2 || v.slots > 64)
    s.refuse("slots", "must be a power of two, 2..64");
}

template <typename Section>
void describe(Section& s, MetricsConfig& v) {
  s.optional("file", v.file);
}

template <typename Section>
void describe(Section& s, RecordConfig& v) {
  s.optional("folder", v.folder);
  s.optional("buffer_events", v.buffer_events);
  s.optional("max_mib", v.max_mib);
  if (!is_power_of_two(v.buffer_events) || v.buffer_events < (1u << 16) || v.buffer_events > (1u << 24))
    s.refuse("buffer_events", "must be a power of two, 65536..16777216");
  if (v.max_mib < 1 || v.max_mib > (1u << 20)) s.refuse("max_mib", "must lie in 1..1048576");
}

std::vector<std::string> parse_daemon_config(std::string_view text, const std::filesystem::path& path,
                                             DaemonConfig& config) {
  const std::string name = path.string();
  config = {};
  config.file = path;
  std::vector<std::string> problems;
  const auto attempt = [&problems](const auto& step) {
    try {
      step();
    } catch (const Error& error) {
      problems.emplace_back(error.what());
    }
  };
  toml::table root;
  try {
    root = toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    attempt([&] {
      recording::fail(name, error.source(), "is no valid TOML: " + std::string(error.description()));
    });
    return problems;
  }
  recording::FileReader file(root, name);
  if (!root.contains("source"))
    problems.push_back(name + ": lacks the section [source]. `egofocusd --print-config` shows one.");
  attempt([&] { file.section("source", config.source); });
  attempt([&] { file.section("can", config.can); });
  attempt([&] { file.section("engine", config.engine); });
  attempt([&] { file.section("depth", config.depth); });
  attempt([&] { file.section("control", config.control); });
  attempt([&] { file.section("metrics", config.metrics); });
  attempt([&] { file.section("record", config.record); });
  attempt([&] { file.finish(); });
  if (config.depth.socket == config.control.socket)
    problems.push_back(name + ": [depth] and [control] name the same `socket`. Give each its own.");
  const bool is_replay = config.source.events == EventsFrom::kReplay;
  if (is_replay && !config.engine.camera.empty())
    problems.push_back(
        name + ": [engine] `camera` contradicts events = \"replay\": the recording has its own. Remove it.");
  if (!is_replay && config.engine.camera.empty())
    problems.push_back(name + ": [engine] lacks `camera`: devices need a camera.toml (docs/formats.md).");
  return problems;
}

DaemonConfig read_daemon_config(const std::filesystem::path& path) {
  DaemonConfig config;
  const std::vector<std::string> problems =
      parse_daemon_config(recording::read_text_file(path), path, config);
  std::string all;
  for (const std::string& problem : problems) all += (all.empty() ? "" : "\n") + problem;
  if (!all.empty()) throw Error(ExitCode::kConfiguration, all);
  return config;
}

const char* default_config_text() noexcept {
  return
#include "default_config.inc"
      ;
}

}  // namespace egofocus::daemon
