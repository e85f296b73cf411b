// Text of `candump -L` -> CAN frames.
//
//   (1436509052.249713) can0 044#2A366C2BBA        classic, 11-bit id
//   (1436509052.249714) can0 18F02A80#00.7D.00     29-bit id; dots between bytes allowed
//   (1436509052.249715) can0 123##1A0B1            CAN FD, one hex digit of flags
//
// Source: docs/formats.md; can-utils' log format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "hal/can_frame.hpp"
#include "hal/decoded.hpp"
#include "hal/text_lines.hpp"

namespace egofocus {

/// Every line is in exactly one of the counters from `frames` to `over_long`.
struct CandumpCounters {
  std::uint64_t lines = 0;
  std::uint64_t frames = 0;         ///< data frames that were handed out
  std::uint64_t error_frames = 0;   ///< controller errors in the log, not handed out
  std::uint64_t remote_frames = 0;  ///< requests without data, not handed out
  std::uint64_t drop_notices = 0;   ///< DROPCOUNT lines
  std::uint64_t blank = 0;
  std::uint64_t unknown = 0;  ///< neither of the forms above
  std::uint64_t over_long = 0;
  std::uint64_t out_of_order = 0;    ///< of `frames`: earlier than the latest before it. Kept.
  std::uint64_t recorder_drops = 0;  ///< frames that the DROPCOUNT lines say were lost
};

/// Consumes whole lines only, so a caller keeps the tail and brings it again with more bytes; its buffer must
/// hold TextLines::kMaxLineBytes + 1 bytes or more.
/// Times are exact: the decimals are cut after the microsecond, no floating point.
/// Errors: none; what cannot be used is counted.
/// Thread: one at a time. RT: yes, O(bytes).
class CandumpDecoder {
 public:
  /// Stops when `out` is full or no whole line is left.
  Decoded feed(std::span<const std::byte> bytes, std::span<CanFrame> out) noexcept;

  /// For the end of the file: a last line without LF counts as whole. Call it with the bytes that feed() left
  /// over, until all are consumed.
  Decoded finish(std::span<const std::byte> bytes, std::span<CanFrame> out) noexcept;

  [[nodiscard]] const CandumpCounters& counters() const noexcept { return counters_; }

 private:
  Decoded decode(std::span<const std::byte> bytes, std::span<CanFrame> out, bool last) noexcept;
  bool decode_line(std::string_view line, CanFrame& frame) noexcept;

  TextLines lines_;
  CandumpCounters counters_;
  std::int64_t latest_us_ = INT64_MIN;
};

}  // namespace egofocus
