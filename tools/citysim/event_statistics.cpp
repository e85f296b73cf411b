#include "citysim/event_statistics.hpp"

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace egofocus::citysim {
namespace {

constexpr std::int64_t kPeakSpan_us = 10'000;
constexpr std::int64_t kNever = INT64_MIN / 2;

double share(std::uint64_t part, std::uint64_t all) {
  return all == 0 ? 0 : static_cast<double>(part) / static_cast<double>(all);
}

double median(std::vector<std::int64_t>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

/// A time for each pixel of the sensor, with a border so that each has eight neighbours.
class TimeMap {
 public:
  TimeMap(int width_px, int height_px)
      : stride_(static_cast<std::size_t>(width_px) + 2),
        times_(stride_ * (static_cast<std::size_t>(height_px) + 2), kNever) {}

  void set(const Event& event, std::int64_t time) { times_[at(event)] = time; }
  /// Neighbours whose time is at least `least`.
  [[nodiscard]] int neighbours_since(const Event& event, std::int64_t least) const {
    const std::size_t i = at(event);
    int count = 0;
    for (const std::size_t row : {i - stride_, i, i + stride_}) {
      count += times_[row - 1] >= least;
      count += times_[row + 1] >= least;
      if (row != i) count += times_[row] >= least;
    }
    return count;
  }

 private:
  [[nodiscard]] std::size_t at(const Event& event) const { return (event.y + 1u) * stride_ + event.x + 1u; }
  std::size_t stride_;
  std::vector<std::int64_t> times_;
};

void count_neighbours(std::span<const Event> events, int width_px, int height_px, EventStatistics& s) {
  TimeMap last(width_px, height_px);
  std::vector<bool> announced;
  std::uint64_t unannounced = 0;
  std::uint64_t neighbours = 0;
  for (const Event& event : events) {
    announced.push_back(last.neighbours_since(event, event.t_us - kSupport_us) > 0);
    unannounced += !announced.back();
    neighbours += static_cast<std::uint64_t>(last.neighbours_since(event, event.t_us - kTogether_us));
    last.set(event, event.t_us);
  }
  // The same backwards: times with their sign turned rise.
  TimeMap next(width_px, height_px);
  std::uint64_t isolated = 0;
  for (std::size_t i = events.size(); i-- > 0;) {
    const std::int64_t time = -events[i].t_us;
    isolated += !announced[i] && next.neighbours_since(events[i], time - kSupport_us) == 0;
    next.set(events[i], time);
  }
  s.unannounced_share = share(unannounced, events.size());
  s.isolated_share = share(isolated, events.size());
  s.neighbours = share(neighbours, events.size());
}

/// Intervals and bursts, pixel by pixel.
class PixelTally {
 public:
  explicit PixelTally(std::size_t pixels) : pixels_(pixels) {}

  void take(std::size_t index, const Event& event) {
    Pixel& pixel = pixels_[index];
    if (pixel.events > 0) {
      const std::int64_t interval_us = event.t_us - pixel.last_us;
      const bool flips = event.polarity != pixel.polarity;
      intervals_.push_back(interval_us);
      flips_ += flips;
      if (flips || interval_us > kBurstGap_us) {
        end_burst(pixel);
      } else {
        gaps_.push_back(interval_us);
      }
    }
    if (pixel.burst_events == 0) pixel.burst_begin_us = event.t_us;
    ++pixel.burst_events;
    ++pixel.events;
    pixel.last_us = event.t_us;
    pixel.polarity = event.polarity;
  }

  void finish(std::uint64_t events, EventStatistics& s) {
    for (Pixel& pixel : pixels_) {
      if (pixel.burst_events > 0) end_burst(pixel);
    }
    std::array<std::uint64_t, kIntervalBounds_us.size() + 1> bins{};
    for (const std::int64_t interval_us : intervals_) {
      const auto bound = std::upper_bound(kIntervalBounds_us.begin(), kIntervalBounds_us.end(), interval_us);
      ++bins[static_cast<std::size_t>(bound - kIntervalBounds_us.begin())];
    }
    for (std::size_t i = 0; i < bins.size(); ++i) s.interval_share[i] = share(bins[i], intervals_.size());
    s.flip_share = share(flips_, intervals_.size());
    s.median_interval_us = median(intervals_);
    const std::uint64_t bursts = bursts_[0] + bursts_[1] + bursts_[2] + bursts_[3];
    for (std::size_t i = 0; i < bursts_.size(); ++i) s.burst_share[i] = share(bursts_[i], bursts);
    s.burst_events = share(events, bursts);
    s.median_burst_us = median(burst_lengths_us_);
    s.median_gap_us = median(gaps_);
    count_hot(events, s);
  }

 private:
  struct Pixel {
    std::int64_t last_us = 0;
    std::int64_t burst_begin_us = 0;
    std::uint64_t events = 0;
    std::uint64_t burst_events = 0;
    std::uint8_t polarity = 0;
  };

  void end_burst(Pixel& pixel) {
    ++bursts_[std::min<std::size_t>(pixel.burst_events, bursts_.size()) - 1];
    if (pixel.burst_events > 1) burst_lengths_us_.push_back(pixel.last_us - pixel.burst_begin_us);
    pixel.burst_events = 0;
  }

  void count_hot(std::uint64_t events, EventStatistics& s) const {
    std::vector<std::int64_t> counts;
    for (const Pixel& pixel : pixels_) {
      if (pixel.events > 0) counts.push_back(static_cast<std::int64_t>(pixel.events));
    }
    s.active_share = share(counts.size(), pixels_.size());
    const std::uint64_t limit = std::max<std::uint64_t>(10, static_cast<std::uint64_t>(median(counts)) * 10);
    std::uint64_t hot = 0;
    std::uint64_t of_hot = 0;
    for (const Pixel& pixel : pixels_) {
      if (pixel.events < limit) continue;
      ++hot;
      of_hot += pixel.events;
    }
    s.hot_pixel_share = share(hot, pixels_.size());
    s.hot_event_share = share(of_hot, events);
  }

  std::vector<Pixel> pixels_;
  std::vector<std::int64_t> intervals_;
  std::vector<std::int64_t> gaps_;
  std::vector<std::int64_t> burst_lengths_us_;
  std::array<std::uint64_t, 4> bursts_{};
  std::uint64_t flips_ = 0;
};

double peak_to_mean(std::span<const Event> events) {
  const std::int64_t first_us = events.front().t_us;
  const auto slices = static_cast<std::uint64_t>((events.back().t_us - first_us) / kPeakSpan_us);
  if (slices == 0) return 1;  // not one whole slice
  std::uint64_t most = 0;
  std::uint64_t counted = 0;
  std::size_t i = 0;
  for (std::uint64_t slice = 0; slice < slices && i < events.size();) {
    std::uint64_t count = 0;
    const std::int64_t end_us = first_us + static_cast<std::int64_t>(slice + 1) * kPeakSpan_us;
    for (; i < events.size() && events[i].t_us < end_us; ++i) ++count;
    most = std::max(most, count);
    counted += count;
    // Empty slices are passed over at once: a file's times may lie years apart.
    if (i < events.size())
      slice = std::max(slice + 1, static_cast<std::uint64_t>((events[i].t_us - first_us) / kPeakSpan_us));
  }
  return static_cast<double>(most) * static_cast<double>(slices) / static_cast<double>(counted);
}

}  // namespace

EventStatistics event_statistics(std::span<const Event> events, int width_px, int height_px) {
  EventStatistics s;
  s.events = events.size();
  if (events.empty()) return s;
  const std::size_t pixels = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  PixelTally tally(pixels);
  std::uint64_t on = 0;
  std::int64_t before_us = events.front().t_us;
  for (const Event& event : events) {
    if (event.x >= width_px || event.y >= height_px)
      throw std::invalid_argument("event_statistics: an event outside the sensor.");
    if (event.t_us < before_us) throw std::invalid_argument("event_statistics: events out of order.");
    before_us = event.t_us;
    on += event.polarity;
    tally.take(event.y * static_cast<std::size_t>(width_px) + event.x, event);
  }
  s.duration_us = events.back().t_us - events.front().t_us;
  s.on_share = share(on, events.size());
  if (s.duration_us > 0)
    s.pixel_rate_hz = share(events.size(), pixels) / (static_cast<double>(s.duration_us) * 1e-6);
  s.peak_to_mean = peak_to_mean(events);
  tally.finish(events.size(), s);
  count_neighbours(events, width_px, height_px, s);
  return s;
}

}  // namespace egofocus::citysim
