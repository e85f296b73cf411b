// All that a Prophesee stream can get wrong, counted; and what it tells beside events.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace egofocus {

/// One enumerator per kind. "Refused" words leave the decoder's state as it was.
enum class EvtViolation : std::uint8_t {
  kUnknownWord,       ///< a type that the format does not define (some cameras pad with 0x9999); skipped
  kBeforeTimeHigh,    ///< events before the first TIME_HIGH, or the first after a loss; dropped
  kBeforeY,           ///< EVT3: events before any ADDR_Y; dropped
  kBeforeBase,        ///< EVT3: a vector before any VECT_BASE_X; dropped
  kOutOfRange,        ///< events with x or y outside the sensor; dropped
  kTimeHighBackward,  ///< TIME_HIGH stepped back by less than half its range; refused
  kTimeHighLeap,      ///< TIME_HIGH leapt ahead by half its range or more: data were lost; refused
  kTimeReset,  ///< so many TIME_HIGH words in a row were refused that the sensor is believed: time jumps
  kTimeLowBackward,  ///< EVT3: TIME_LOW stepped back under the same TIME_HIGH; taken as sent
  kEventBackward,    ///< an event (or row of events) older than the one before; given out as sent
};
inline constexpr std::size_t kEvtViolationKinds = 10;

/// Counts since construction. Each event that was in the stream is in `events` or in `dropped_events`.
struct EvtCounters {
  std::uint64_t events = 0;          ///< taken over, so given out or waiting for room
  std::uint64_t dropped_events = 0;  ///< the violations say why
  std::uint64_t triggers = 0;        ///< EXT_TRIGGER edges
  std::uint64_t sensor_in = 0;       ///< events that entered the sensor's rate controller (OTHERS 0x14)
  std::uint64_t sensor_out = 0;  ///< events that left it (OTHERS 0x16); less than sensor_in: the sensor drops
  std::array<std::uint64_t, kEvtViolationKinds>
      violations{};  ///< by EvtViolation; words, rows or resets, not events

  [[nodiscard]] std::uint64_t operator[](EvtViolation kind) const noexcept {
    return violations[static_cast<std::size_t>(kind)];
  }
  void count(EvtViolation kind, std::uint64_t events_lost = 0) noexcept {
    ++violations[static_cast<std::size_t>(kind)];
    dropped_events += events_lost;
  }
  /// The payload of an OTHERS word or sequence. Subtypes other than the two counters mean nothing to us.
  void take_others(std::uint32_t subtype, std::uint32_t payload) noexcept {
    if (subtype == 0x14) sensor_in += payload;
    if (subtype == 0x16) sensor_out += payload;
  }
};

/// The newest edge on the trigger input.
struct EvtTrigger {
  std::int64_t t_us = 0;  ///< raw device time
  std::uint8_t id = 0;
  std::uint8_t value = 0;  ///< level after the edge
};

}  // namespace egofocus
