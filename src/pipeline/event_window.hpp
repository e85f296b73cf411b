// The newest kept events, oldest first, and the choice of those that a tick warps.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "egofocus/config.hpp"
#include "egofocus/status.hpp"

namespace egofocus {

/// An event as the window keeps it: 6 bytes. Pixels below 2048; time modulo 2^26 us, far more than a window
/// is long, with its upper bits beside the pixel's.
class WindowEvent {
 public:
  static constexpr std::uint32_t kTimeMask = (1u << 26) - 1;

  WindowEvent() noexcept = default;
  explicit WindowEvent(const Event& event) noexcept
      : t_(static_cast<std::uint16_t>(event.t_us)),
        x_(static_cast<std::uint16_t>(event.x | (event.t_us >> 16 & 31) << 11)),
        y_(static_cast<std::uint16_t>(event.y | (event.t_us >> 21 & 31) << 11)) {}

  [[nodiscard]] std::uint16_t x() const noexcept { return x_ & 2047; }
  [[nodiscard]] std::uint16_t y() const noexcept { return y_ & 2047; }
  [[nodiscard]] std::uint32_t t_low_us() const noexcept {
    return t_ | static_cast<std::uint32_t>(x_ >> 11) << 16 | static_cast<std::uint32_t>(y_ >> 11) << 21;
  }

 private:
  std::uint16_t t_ = 0;
  std::uint16_t x_ = 0;
  std::uint16_t y_ = 0;
};

class EventWindow {
 public:
  static Status check(const WindowConfig& config) noexcept;

  /// Holds 4 * max_events; when more come within max_age_us the oldest are overwritten.
  EventWindow(const WindowConfig& config, Arena& arena) noexcept;

  /// Times never go back and pixels lie on the sensor (the filter sees to both). Thread: the tick. RT: yes.
  void add(const Event& event) noexcept;

  /// Events of one tick: those with begin_us <= t <= end_us, evenly decimated when there are more than
  /// max_events (event floor(i * in_window / count) for i < count: evenly spread, and the same each time).
  struct Selection {
    std::uint64_t first = 0;  ///< number of the oldest event, counted since the start
    std::uint64_t in_window = 0;
    std::uint32_t count = 0;  ///< of those selected, <= max_events
  };
  [[nodiscard]] Selection select(std::int64_t begin_us, std::int64_t end_us) const noexcept;

  /// i-th event of a selection, i < count. Thread: any between two add(). RT: yes.
  [[nodiscard]] const WindowEvent& at(const Selection& s, std::uint32_t i) const noexcept {
    const std::uint64_t offset = s.in_window == s.count ? i : i * s.in_window / s.count;
    return events_[static_cast<std::size_t>((s.first + offset) % events_.size())];
  }

  /// How long before end_us an event lies. Thread: any. RT: yes.
  static std::uint32_t age_us(const WindowEvent& event, std::int64_t end_us) noexcept {
    return (static_cast<std::uint32_t>(end_us) - event.t_low_us()) & WindowEvent::kTimeMask;
  }

  /// Time of the newest event; INT64_MIN before the first. Thread: the tick.
  [[nodiscard]] std::int64_t newest_us() const noexcept { return newest_us_; }

 private:
  std::uint32_t max_events_;
  std::int64_t max_age_us_;
  std::span<WindowEvent> events_;
  std::uint64_t added_ = 0;
  std::uint64_t whole_from_ = 0;  // number of the first event after the newest gap of more than max_age_us
  std::int64_t newest_us_ = INT64_MIN;
};

}  // namespace egofocus
