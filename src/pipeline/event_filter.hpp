// The one step before the window: range, order, hot pixels, refractory time, isolated events. Deterministic:
// what is kept depends on the events alone. Every event that goes in is counted on exactly one line.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "egofocus/config.hpp"
#include "egofocus/health.hpp"
#include "egofocus/status.hpp"

namespace egofocus {

class EventFilter {
 public:
  static Status check(const Config& config) noexcept;

  /// Storage is taken only for the stages that are on: 8 bytes per pixel each, hot pixels 5.
  EventFilter(const Config& config, Arena& arena) noexcept;

  /// True when the event goes into the window. Thread: the tick. RT: yes.
  bool keep(const Event& event) noexcept;

  /// The stages' counts; `in` and `ring_dropped` are the ring's. Thread: the tick.
  [[nodiscard]] const EventCounters& counters() const noexcept { return counters_; }
  EventCounters& counters() noexcept { return counters_; }

 private:
  bool is_hot(std::size_t pixel, std::int64_t t_us) noexcept;
  bool is_isolated(const Event& event) noexcept;

  FilterConfig config_;
  std::int32_t width_;
  std::int32_t height_;
  std::int64_t hot_count_limit_;
  std::int64_t newest_us_ = INT64_MIN;
  std::int64_t learn_until_us_ = INT64_MIN;
  std::uint32_t stretch_ = 0;             // of learning, by number
  std::span<std::int64_t> last_kept_us_;  // refractory
  std::span<std::int64_t> last_seen_us_;  // isolated; one pixel of border all around
  std::span<std::uint8_t> hot_;
  std::span<std::uint32_t> learn_count_;  // 24 bits, below 8 of the stretch that it is of
  EventCounters counters_;
};

}  // namespace egofocus
