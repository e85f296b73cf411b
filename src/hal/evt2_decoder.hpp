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
  /// `so_far`: counts to go on from, of a decoder before this one.
  explicit Evt2Decoder(SensorSize size, const EvtCounters& so_far = {}) noexcept
      : row_(size), counters_(so_far) {}

  /// Promise and protocol: see Decoded. Thread: one. RT: yes.
  Decoded feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept;

  /// Data before the next bytes were lost: half a word is dropped and counted, and nothing is given out
  /// before the next TIME_HIGH.
  void resync() noexcept {
    drop_partial();
    time_high_.lose();
    others_subtype_ = 0;
  }
  /// Half a word at the end of what was fed is dropped and counted.
  void drop_partial() noexcept {
    if (words_.drop_partial() > 0) counters_.count(EvtViolation::kUnknownWord);
  }

  /// Newest device time; moves on without events, too. Precondition: is_time_known().
  [[nodiscard]] std::int64_t time_us() const noexcept { return time_high_.value() * 64 + time_low_; }
  [[nodiscard]] bool is_time_known() const noexcept { return time_high_.known(); }
  [[nodiscard]] const EvtCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] const EvtTrigger& last_trigger() const noexcept { return trigger_; }

 private:
  std::size_t take(std::uint32_t word, std::span<Event> room) noexcept;

  WordReader<std::uint32_t> words_;
  TimeHighReader time_high_{28};
  std::int64_t time_low_ = 0;
  EventRow row_;
  std::uint32_t others_subtype_ = 0;  // of the OTHER whose payload comes next; 0: none
  EvtCounters counters_;
  EvtTrigger trigger_;
};

}  // namespace egofocus
