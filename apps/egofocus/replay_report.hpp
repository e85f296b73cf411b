// What a replay has to say: a line per tick that any machine prints alike, and a summary with this machine's
// times.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "egofocus/health.hpp"
#include "egofocus/types.hpp"
#include "recording/depth_error.hpp"
#include "recording/json.hpp"
#include "recording/replay.hpp"
#include "recording/tick_times.hpp"

namespace egofocus::app {

using recording::Json;

/// FNV-1a, 64 bits, over the frame's depth, confidence, scale, flags and counts: equal hashes, equal frames.
[[nodiscard]] std::uint64_t frame_hash(const DepthFrame& frame) noexcept;

/// Text of FrameFlag bits: "none", "no_parallax", "stale_velocity+overload", ...
[[nodiscard]] std::string flags_text(std::uint32_t flags);

class ReplayReport {
 public:
  void add(const DepthFrame& frame, double milliseconds);
  /// Of the tick that was added last; of those with depth alone.
  void add_stages(const StageTimes& stages);
  void add_truth(const recording::DepthError& error);

  [[nodiscard]] std::size_t ticks() const { return times_.ticks(); }

  /// Deterministic: one line per tick, then counts and health. The same bytes on every machine, ISA and
  /// thread count; what tests/golden holds.
  [[nodiscard]] std::string golden_text(recording::Replay& replay) const;

  /// Everything, times included. `beside`: the report of another backend on the same ticks, or null.
  [[nodiscard]] Json summary(recording::Replay& replay, const ReplayReport* beside) const;

 private:
  /// Coverage, times and accuracy.
  void add_findings(Json& facts) const;

  std::vector<std::string> lines_;
  recording::TickTimes times_;
  std::vector<StageTimes> stages_;
  std::vector<double> coverage_;  // of the ticks that gave depth
  std::vector<recording::DepthError> errors_;
  std::uint64_t events_ = 0;
  std::uint64_t votes_ = 0;
  std::uint64_t hash_ = 0;
  std::int64_t first_us_ = 0;
  std::int64_t last_us_ = 0;
  std::uint64_t with_depth_ = 0;
};

}  // namespace egofocus::app
