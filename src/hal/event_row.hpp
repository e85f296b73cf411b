// Up to 32 pixels of one row that changed at the same time, on their way into a caller's span.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/types.hpp"
#include "hal/evt_violations.hpp"
#include "hal/sensor_size.hpp"

namespace egofocus {

/// Checks range and order, gives out events from the smallest x on, and holds back what finds no room: no
/// event is ever lost for want of space. All three EVT decoders end here.
class EventRow {
 public:
  explicit constexpr EventRow(SensorSize size) noexcept : size_(size) {}

  /// Bit i of `mask` stands for pixel (event.x + i, event.y) with the time and polarity of `event`. Returns
  /// the events written to `room`. Precondition: nothing is held back. Thread: one. RT: yes.
  std::size_t place(const Event& event, std::uint32_t mask, std::span<Event> room,
                    EvtCounters& counters) noexcept {
    const std::uint32_t inside = mask & mask_inside(event);
    if (inside != mask) {
      counters.count(EvtViolation::kOutOfRange, static_cast<std::uint64_t>(std::popcount(mask ^ inside)));
    }
    if (inside == 0) return 0;
    if (event.t_us < newest_us_) counters.count(EvtViolation::kEventBackward);
    newest_us_ = event.t_us;
    counters.events += static_cast<std::uint64_t>(std::popcount(inside));
    event_ = event;
    held_ = inside;
    return resume(room);
  }

  /// Goes on with what was held back. Thread: one. RT: yes.
  std::size_t resume(std::span<Event> room) noexcept {
    std::size_t written = 0;
    for (; held_ != 0 && written < room.size(); held_ &= held_ - 1) {
      room[written] = event_;
      room[written++].x = static_cast<std::uint16_t>(event_.x + std::countr_zero(held_));
    }
    return written;
  }

 private:
  [[nodiscard]] std::uint32_t mask_inside(const Event& event) const noexcept {
    if (event.x >= size_.width_px || event.y >= size_.height_px) return 0;
    const int columns = size_.width_px - event.x;
    return columns >= 32 ? ~0u : (1u << columns) - 1;
  }

  SensorSize size_;
  Event event_;
  std::uint32_t held_ = 0;
  std::int64_t newest_us_ = INT64_MIN;
};

}  // namespace egofocus
