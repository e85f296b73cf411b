// The way out of the pixel array: one server, a short queue, the rest is lost.
#pragma once

#include <cstdint>
#include <optional>

namespace egofocus::citysim {

class DvsReadout {
 public:
  /// `events_per_s` 0: no limit.
  DvsReadout(double events_per_s, double queue_events)
      : service_ps_(events_per_s > 0 ? static_cast<std::int64_t>(1e12 / events_per_s) : 0),
        longest_wait_ps_(static_cast<std::int64_t>(queue_events * static_cast<double>(service_ps_))) {}

  /// When an event that asks at `t_us` is stamped, or nothing: lost. Requests come in order of time.
  std::optional<std::int64_t> accept(std::int64_t t_us) {
    if (service_ps_ == 0) return t_us;
    // Nobody waits longer than longest_wait_ps_ + service_ps_, so no longer pause needs to be known.
    const std::int64_t pause_us = t_us - now_us;
    busy_ps = pause_us > busy_ps / 1000000 ? 0 : busy_ps - pause_us * 1000000;
    now_us = t_us;
    if (busy_ps > longest_wait_ps_) return std::nullopt;
    const std::int64_t stamp_us = t_us + busy_ps / 1000000;
    busy_ps += service_ps_;
    return stamp_us;
  }

  // What changes from call to call, for the sensor's state.
  std::int64_t now_us = 0;
  std::int64_t busy_ps = 0;  ///< from now on

 private:
  std::int64_t service_ps_;
  std::int64_t longest_wait_ps_;
};

}  // namespace egofocus::citysim
