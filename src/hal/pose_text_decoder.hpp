// Text lines `t px py pz qx qy qz qw` -> poses. t in seconds, position in metres, p_world = R(q) p_camera +
// position.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "egofocus/types.hpp"
#include "hal/decoded.hpp"
#include "hal/text_lines.hpp"

namespace egofocus {

/// Every line is in exactly one of the counters from `poses` to `over_long`.
struct PoseTextCounters {
  std::uint64_t lines = 0;
  std::uint64_t poses = 0;
  std::uint64_t blank = 0;           ///< empty, or a comment that begins with #
  std::uint64_t malformed = 0;       ///< not eight finite numbers
  std::uint64_t bad_quaternion = 0;  ///< norm outside 0.99..1.01
  std::uint64_t over_long = 0;
  std::uint64_t out_of_order = 0;  ///< of `poses`: earlier than the latest before it. Kept.
};

/// Consumes whole lines only, as CandumpDecoder does. Times are exact: the decimals are cut after the
/// microsecond, no floating point. Quaternions come out with norm 1. Errors: none; what cannot be used is
/// counted. Thread: one at a time. RT: yes, O(bytes).
class PoseTextDecoder {
 public:
  /// Stops when `out` is full or no whole line is left.
  Decoded feed(std::span<const std::byte> bytes, std::span<PoseSample> out) noexcept;

  /// For the end of the file: a last line without LF counts as whole. Call it with the bytes that feed() left
  /// over, until all are consumed.
  Decoded finish(std::span<const std::byte> bytes, std::span<PoseSample> out) noexcept;

  [[nodiscard]] const PoseTextCounters& counters() const noexcept { return counters_; }

 private:
  Decoded decode(std::span<const std::byte> bytes, std::span<PoseSample> out, bool last) noexcept;
  bool decode_line(std::string_view line, PoseSample& pose) noexcept;

  TextLines lines_;
  PoseTextCounters counters_;
  std::int64_t latest_us_ = INT64_MIN;
};

}  // namespace egofocus
