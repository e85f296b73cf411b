// What a stream of events looks like, in numbers that do not need the scene: to hold simulated ones against
// real ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/types.hpp"

namespace egofocus::citysim {

/// Bounds of the histogram of intervals, half a decade each; below the first and from the last on are bins,
/// too.
inline constexpr std::array<std::int64_t, 11> kIntervalBounds_us = {
    10, 32, 100, 316, 1000, 3162, 10'000, 31'623, 100'000, 316'228, 1'000'000};

inline constexpr std::int64_t kBurstGap_us = 10'000;
inline constexpr std::int64_t kSupport_us = 10'000;
inline constexpr std::int64_t kTogether_us = 2'000;

/// Shares are 0 to 1; what has nothing to count is 0. A pixel is active when it has an event. An interval
/// lies between two successive events of one pixel. A burst is a row of events of one pixel and polarity with
/// gaps of at most kBurstGap_us: about what one edge leaves there.
struct EventStatistics {
  std::uint64_t events = 0;
  std::int64_t duration_us = 0;  ///< from the first event to the last
  double pixel_rate_hz = 0;      ///< events per pixel of the sensor and second
  double active_share = 0;       ///< of the pixels
  double on_share = 0;           ///< of the events
  double peak_to_mean = 0;       ///< events of the busiest 10 ms, over the mean of 10 ms

  std::array<double, kIntervalBounds_us.size() + 1> interval_share{};  ///< of the intervals, each bin
  double median_interval_us = 0;
  double flip_share = 0;  ///< of the intervals: polarity changes

  double burst_events = 0;              ///< mean
  std::array<double, 4> burst_share{};  ///< of the bursts: with 1, 2, 3, and 4 or more events
  double median_burst_us = 0;           ///< first to last event, of bursts with two or more
  double median_gap_us = 0;             ///< between two successive events of a burst

  double isolated_share = 0;     ///< of the events: none of the 8 neighbours within +-kSupport_us
  double unannounced_share = 0;  ///< none of the 8 neighbours in the kSupport_us before: a filter's noise
  double neighbours = 0;         ///< mean number of the 8 neighbours with an event in the kTogether_us before

  double hot_pixel_share =
      0;  ///< of the pixels: 10 times the median count of the active ones, and 10 or more
  double hot_event_share = 0;  ///< of the events: on such pixels
};

/// Throws std::invalid_argument on an event outside the sensor or before the one ahead of it.
[[nodiscard]] EventStatistics event_statistics(std::span<const Event> events, int width_px, int height_px);

}  // namespace egofocus::citysim
