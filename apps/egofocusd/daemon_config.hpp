// The configuration file of egofocusd: egofocusd.toml is the commented default. daemon_config.cpp has the
// keys.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "egofocus/config.hpp"
#include "egofocus/engine.hpp"
#include "hal/socketcan_source.hpp"

namespace egofocus::daemon {

enum class EventsFrom : std::uint8_t { kReplay, kUsb, kV4l2 };
enum class MotionFrom : std::uint8_t { kReplay, kCan };
enum class AtEnd : std::uint8_t { kStop, kRepeat };

struct SourceConfig {
  EventsFrom events = EventsFrom::kReplay;
  MotionFrom motion = MotionFrom::kReplay;
  std::filesystem::path recording;
  ClockKind clock = ClockKind::kMonotonic;
  std::int64_t first_tick_us = 0;  ///< clock = "device": t_0 of the ticks
  AtEnd at_end = AtEnd::kStop;
  bool wait_for_reader = false;
};

struct EngineConfig {
  std::filesystem::path camera;
  Backend backend = Backend::kNetwork;
  std::filesystem::path model;
  std::int32_t threads = 1;
  std::optional<double> rate_hz;
  std::int64_t lateness_us = 5000;
  std::int64_t max_late_us = 0;
  std::int32_t max_event_rate_hz = 0;
  RealTimeConfig real_time;
};

struct SocketConfig {
  std::filesystem::path socket;
  bool group = true;
};

struct DepthConfig : SocketConfig {
  std::uint32_t slots = 4;
};

struct MetricsConfig {
  std::filesystem::path file;
};

struct RecordConfig {
  std::filesystem::path folder;
  std::uint32_t buffer_events = 1u << 20;
  std::uint32_t max_mib = 4096;
};

struct CanConfig : SocketCanConfig {};

struct DaemonConfig {
  std::filesystem::path file;
  SourceConfig source;
  CanConfig can;
  EngineConfig engine;
  DepthConfig depth{{"/run/egofocus/depth.sock", true}, 4};
  SocketConfig control{"/run/egofocus/control.sock", true};
  MetricsConfig metrics;
  RecordConfig record;
};

/// Everything that is wrong with the text, a line each: file, line, what. Empty: `config_out` is sound in
/// itself. Whether files, folders and devices are there is for find_problems() to say.
[[nodiscard]] std::vector<std::string> parse_daemon_config(std::string_view text,
                                                           const std::filesystem::path& name,
                                                           DaemonConfig& config_out);

/// Reads and parses. Throws Error: kFile when it cannot be read, kConfiguration with all problems.
[[nodiscard]] DaemonConfig read_daemon_config(const std::filesystem::path& path);

/// The commented default, as `egofocusd --print-config` prints it.
[[nodiscard]] const char* default_config_text() noexcept;

}  // namespace egofocus::daemon
