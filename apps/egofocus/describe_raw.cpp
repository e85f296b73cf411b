#include "describe_raw.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "hal/evt_decoder.hpp"
#include "recording/error.hpp"

namespace egofocus::app {
namespace {

constexpr std::int64_t kPeakSpanUs = 10000;

constexpr std::array<const char*, kEvtViolationKinds> kViolationNames = {
    "unknown_word",  "before_time_high", "before_y",   "before_base",       "out_of_range",
    "time_backward", "time_leap",        "time_reset", "time_low_backward", "event_backward"};

/// What is counted of the events beside what the decoder counts.
struct Tally {
  std::uint64_t events = 0;
  std::uint64_t on = 0;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
  std::int64_t span = 0;  // number of the current 10 ms
  std::uint64_t in_span = 0;
  std::uint64_t most_in_span = 0;

  void take(const Event& event) {
    if (events == 0) first_us = last_us = event.t_us;
    first_us = std::min(first_us, event.t_us);
    last_us = std::max(last_us, event.t_us);
    ++events;
    on += event.polarity;
    if (event.t_us / kPeakSpanUs != span) in_span = 0;
    span = event.t_us / kPeakSpanUs;
    most_in_span = std::max(most_in_span, ++in_span);
  }

  void add_to(Json& facts) const {
    const double seconds = static_cast<double>(last_us - first_us) * 1e-6;
    facts.add("events", events).add("on_events", on).add("first_us", first_us).add("last_us", last_us);
    facts.add("duration_s", seconds)
        .add("mean_events_per_s",
             seconds > 0 ? static_cast<std::int64_t>(static_cast<double>(events) / seconds) : 0)
        .add("peak_events_per_s", most_in_span * (1000000 / kPeakSpanUs));
  }
};

}  // namespace

void add_event_facts(std::span<const Event> events, Json& facts) {
  Tally tally;
  for (const Event& event : events) tally.take(event);
  tally.add_to(facts);
}

Json describe_raw(std::span<const std::byte> file, const std::string& name) {
  RawHeader header;
  const Status status = parse_raw_header(file, header);
  if (!status.ok()) {
    char text[200];
    status.describe(text);
    throw recording::Error(recording::ExitCode::kBadFile, name, text);
  }
  EvtDecoder decoder(header.format, header.size);
  std::span<const std::byte> rest = file.subspan(header.header_bytes);
  const std::size_t cut_off_bytes = rest.size() % word_bytes(header.format);
  std::vector<Event> block(1u << 14);
  Tally tally;
  for (Decoded step; !rest.empty() || step.produced == block.size(); rest = rest.subspan(step.consumed)) {
    step = decoder.feed(rest, block);
    for (std::size_t i = 0; i < step.produced; ++i) tally.take(block[i]);
    if (step.consumed == 0 && step.produced == 0) break;
  }
  const EvtCounters& counters = decoder.counters();
  Json violations;
  for (std::size_t i = 0; i < kEvtViolationKinds; ++i)
    violations.add(kViolationNames[i], counters.violations[i]);

  Json facts;
  facts.add("kind", "Prophesee RAW")
      .add("format", to_string(header.format))
      .add("width_px", header.size.width_px)
      .add("height_px", header.size.height_px);
  if (header.sensor_name[0]) facts.add("sensor", header.sensor_name);
  if (header.date[0]) facts.add("date", header.date);
  facts.add("bytes", file.size());
  tally.add_to(facts);
  facts.add("dropped_events", counters.dropped_events)
      .add("triggers", counters.triggers)
      .add("cut_off_bytes", cut_off_bytes)
      .add("violations", violations);
  return facts;
}

}  // namespace egofocus::app
