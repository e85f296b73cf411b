// How long ticks took on this machine.
#pragma once

#include <cstddef>
#include <vector>

#include "egofocus/types.hpp"

namespace egofocus::recording {

struct Percentiles {
  double p50 = 0;
  double p99 = 0;
  double max = 0;
};
/// Zeros of none.
[[nodiscard]] Percentiles percentiles(std::vector<double> values);

class TickTimes {
 public:
  /// tick_ms: from before Engine::tick() to its return, the way of the samples into the window included.
  void add(const DepthFrame& frame, double tick_ms);
  void add(const TickTimes& other);

  [[nodiscard]] std::size_t ticks() const { return tick_ms_.size(); }
  [[nodiscard]] Percentiles tick_ms() const { return percentiles(tick_ms_); }
  /// Of the frames that were measured, not carried: from the time of the newest event that the depth rests on
  /// to the depth, were the tick at its time: its age at the tick and the tick itself.
  [[nodiscard]] Percentiles event_to_depth_ms() const { return percentiles(event_to_depth_ms_); }

 private:
  std::vector<double> tick_ms_;
  std::vector<double> event_to_depth_ms_;
};

}  // namespace egofocus::recording
