// Prophesee EVT 3.0: 16-bit words, each of which changes one part of the state: time, row, column, events.
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
/// Events outside the sensor are dropped and counted, older ones given out as sent and counted. Time has 24
/// bits on the wire: a silence above 8.4 s in which the sensor sends no TIME_HIGH either cannot be told from
/// a shorter one. Source: facts, B3. Thread: one. RT: yes, O(bytes).
class Evt3Decoder {
 public:
  /// `so_far`: counts to go on from, of a decoder before this one.
  explicit Evt3Decoder(SensorSize size, const EvtCounters& so_far = {}) noexcept
      : row_(size), counters_(so_far) {}

  /// Promise and protocol: see Decoded. Thread: one. RT: yes.
  Decoded feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept;

  /// Data before the next bytes were lost: half a word is dropped and counted, and nothing is given out
  /// before the next TIME_HIGH; a row, and a vector's base, must come anew as well.
  void resync() noexcept {
    drop_partial();
    time_high_.lose();
    has_y_ = has_base_ = false;
    others_ = {};
  }
  /// Half a word at the end of what was fed is dropped and counted.
  void drop_partial() noexcept {
    if (words_.drop_partial() > 0) counters_.count(EvtViolation::kUnknownWord);
  }

  /// Newest device time; moves on without events, too. Precondition: is_time_known().
  [[nodiscard]] std::int64_t time_us() const noexcept { return time_high_.value() * 4096 + time_low_; }
  [[nodiscard]] bool is_time_known() const noexcept { return time_high_.known(); }
  [[nodiscard]] const EvtCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] const EvtTrigger& last_trigger() const noexcept { return trigger_; }

 private:
  // The OTHERS word whose payload is coming in.
  struct Others {
    std::uint32_t subtype = 0;
    int next_shift = 0;
  };

  std::size_t take(std::uint16_t word, std::span<Event> room) noexcept;
  std::size_t take_vector(std::uint32_t mask, int columns, std::span<Event> room) noexcept;
  std::size_t place(std::uint16_t x, std::uint8_t polarity, std::uint32_t mask,
                    std::span<Event> room) noexcept;
  void take_others_part(std::uint32_t type, std::uint32_t payload) noexcept;
  void take_time_low(std::uint16_t low) noexcept;

  WordReader<std::uint16_t> words_;
  TimeHighReader time_high_{12};
  std::uint16_t time_low_ = 0;
  std::uint16_t y_ = 0;
  std::uint16_t base_x_ = 0;  // of the next vector
  std::uint8_t base_polarity_ = 0;
  bool has_y_ = false;
  bool has_base_ = false;
  Others others_;
  EventRow row_;
  EvtCounters counters_;
  EvtTrigger trigger_;
};

}  // namespace egofocus
