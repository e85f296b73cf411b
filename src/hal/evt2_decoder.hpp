// Prophesee EVT 2.0: 32-bit words, one event each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/decoded.hpp"
#include "hal/event_row.hpp"
#include "hal/evt_time_high.hpp"
#include "hal/evt_violations.hpp"
#include "hal/evt_words.hpp"

namespace egofocus {

/// Bytes in any cut -> events in raw device time (us), unwrapped to 64 bits; its zero is the sensor's own.
/// Events outside the sensor are dropped and counted, older ones given out as sent and counted. Source:
/// facts, B1. Thread: one. RT: yes, O(bytes).
class Evt2Decoder {
 public:
  explicit Evt2Decoder(SensorSize size) noexcept : row_(size) {}

  /// Promise and protocol: see Decoded. Thread: one. RT: yes.
  Decoded feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept;

  [[nodiscard]] const EvtCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] const EvtTrigger& last_trigger() const noexcept { return trigger_; }

 private:
  std::size_t take(std::uint32_t word, std::span<Event> room) noexcept;

  WordReader<std::uint32_t> words_;
  TimeHighReader time_high_{28};
  EventRow row_;
  std::uint32_t others_subtype_ = 0;  // of the OTHER whose payload comes next; 0: none
  EvtCounters counters_;
  EvtTrigger trigger_;
};

}  // namespace egofocus
