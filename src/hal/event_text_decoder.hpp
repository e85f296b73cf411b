// Text lines `t x y p` -> events. t in seconds, p 0 or -1 for OFF and 1 for ON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "egofocus/types.hpp"
#include "hal/decoded.hpp"
#include "hal/sensor_size.hpp"
#include "hal/text_lines.hpp"

namespace egofocus {

/// Every line is in exactly one of the counters from `events` to `over_long`.
struct EventTextCounters {
  std::uint64_t lines = 0;
  std::uint64_t events = 0;
  std::uint64_t blank = 0;         ///< empty, or a comment that begins with #
  std::uint64_t malformed = 0;     ///< not four numbers, or p none of -1, 0, 1
  std::uint64_t out_of_range = 0;  ///< x or y outside the sensor
  std::uint64_t over_long = 0;
  std::uint64_t out_of_order = 0;  ///< of `events`: earlier than the one before. Kept.
};

/// Consumes whole lines only: the caller keeps the tail and brings it again with more bytes; its buffer must
/// hold TextLines::kMaxLineBytes + 1 bytes or more. Times are rounded to the nearest microsecond, exactly;
/// numbers may be written like 1.25e-3. No locale. Source: facts, C6. Thread: one at a time. RT: yes,
/// O(bytes).
class EventTextDecoder {
 public:
  explicit EventTextDecoder(SensorSize size) noexcept : size_(size) {}

  /// Stops when `out` is full or no whole line is left. Thread: one at a time. RT: yes.
  Decoded feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept {
    return decode(bytes, out, false);
  }

  /// For the end of the file: a last line without LF counts as whole. Call it with the bytes that feed() left
  /// over, until all are consumed. Thread: one at a time. RT: yes.
  Decoded finish(std::span<const std::byte> bytes, std::span<Event> out) noexcept {
    return decode(bytes, out, true);
  }

  [[nodiscard]] const EventTextCounters& counters() const noexcept { return counters_; }

 private:
  Decoded decode(std::span<const std::byte> bytes, std::span<Event> out, bool last) noexcept;
  bool decode_line(std::string_view line, Event& event) noexcept;

  TextLines lines_;
  SensorSize size_;
  std::int64_t previous_us_ = INT64_MIN;
  EventTextCounters counters_;
};

}  // namespace egofocus
