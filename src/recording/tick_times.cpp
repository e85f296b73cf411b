#include "recording/tick_times.hpp"

#include <algorithm>

namespace egofocus::recording {

Percentiles percentiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    const auto i = static_cast<std::size_t>(share * static_cast<double>(values.size()));
    return values[std::min(i, values.size() - 1)];
  };
  return {at(0.5), at(0.99), values.back()};
}

void TickTimes::add(const DepthFrame& frame, double tick_ms) {
  tick_ms_.push_back(tick_ms);
  if (frame.hypotheses > 0)
    event_to_depth_ms_.push_back(static_cast<double>(frame.age_us) / 1000.0 + tick_ms);
}

void TickTimes::add(const TickTimes& other) {
  tick_ms_.insert(tick_ms_.end(), other.tick_ms_.begin(), other.tick_ms_.end());
  event_to_depth_ms_.insert(event_to_depth_ms_.end(), other.event_to_depth_ms_.begin(),
                            other.event_to_depth_ms_.end());
}

}  // namespace egofocus::recording
