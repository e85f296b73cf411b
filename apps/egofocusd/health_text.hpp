// Health as one flat list of facts, told in two ways: a JSON object, and lines for Prometheus.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "device_facts.hpp"
#include "egofocus/health.hpp"
#include "recorder.hpp"

namespace egofocus::daemon {

struct DaemonFacts {
  Health health;
  RecorderFacts recorder;
  std::vector<DeviceFact> devices;
  std::string isa;
  std::int64_t up_s = 0;
  std::size_t readers = 0;
  std::uint64_t reloads = 0;
  std::uint64_t reloads_failed = 0;
  std::uint64_t log_lines_left_out = 0;
};

struct HealthText {
  std::string json;     ///< {"state": "running", ...}, one line
  std::string metrics;  ///< egofocus_events_in_total 123 ..., with types
};

[[nodiscard]] HealthText health_text(const DaemonFacts& facts);

}  // namespace egofocus::daemon
