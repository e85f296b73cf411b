// Prophesee EVT 2.1: 64-bit words, up to 32 events of one row each.
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

/// How the two 32-bit halves of an EVT 2.1 word lie in the stream; each half is little-endian either way.
enum class Evt21Order : std::uint8_t {
  kLittleEndian,  ///< low half first (GenX320)
  kLegacy,        ///< high half first (IMX636; RAW files that name no endianness)
};

/// Bytes in any cut -> events in raw device time (us), unwrapped to 64 bits; its zero is the sensor's own.
/// Events outside the sensor are dropped and counted, older ones given out as sent and counted. Source:
/// facts, B2. Thread: one. RT: yes, O(bytes).
class Evt21Decoder {
 public:
  /// `so_far`: counts to go on from, of a decoder before this one.
  Evt21Decoder(SensorSize size, Evt21Order order, const EvtCounters& so_far = {}) noexcept
      : row_(size), counters_(so_far), order_(order) {}

  /// Promise and protocol: see Decoded. Thread: one. RT: yes.
  Decoded feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept;

  /// Data before the next bytes were lost: half a word is dropped and counted, and nothing is given out
  /// before the next TIME_HIGH.
  void resync() noexcept {
    drop_partial();
    time_high_.lose();
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
  std::size_t take(std::uint64_t word, std::span<Event> room) noexcept;

  WordReader<std::uint64_t> words_;
  TimeHighReader time_high_{28};
  std::int64_t time_low_ = 0;
  EventRow row_;
  EvtCounters counters_;
  EvtTrigger trigger_;
  Evt21Order order_;
};

}  // namespace egofocus
