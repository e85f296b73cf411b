// The newest kept events, oldest first, and the choice of those that a tick warps.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "egofocus/config.hpp"
#include "egofocus/status.hpp"

namespace egofocus {

/// Three bytes an event: its pixel, and what its time has beyond the begin of its slice. A slice is the power
/// of two of microseconds that leaves the pixel its bits (346x260: 128 us); as events are in order, the
/// number of each slice's first event says the rest.
class EventWindow {
 public:
  static Status check(const WindowConfig& config) noexcept;

  /// Holds 4 * max_events; when more come within max_age_us the oldest are overwritten. Takes 12 bytes per
  /// max_events and 4 bytes per slice of max_age_us, whose number is rounded up to a power of two.
  /// Precondition: check(config) is ok; `sensor` has at most 2^22 pixels.
  EventWindow(const WindowConfig& config, const Intrinsics& sensor, Arena& arena) noexcept;

  /// Times never go back and pixels lie on the sensor (the filter sees to both). Thread: the tick. RT: yes.
  void add(const Event& event) noexcept;

  /// Events of one tick: those with begin_us <= t <= end_us, evenly decimated when there are more than
  /// max_events (event floor(i * in_window / count) for i < count: evenly spread, and the same each time).
  struct Selection {
    std::uint64_t first = 0;  ///< number of the oldest event, counted since the start
    std::uint64_t in_window = 0;
    std::uint32_t count = 0;  ///< of those selected, <= max_events
  };
  /// RT: yes, O(log events).
  [[nodiscard]] Selection select(std::int64_t begin_us, std::int64_t end_us) const noexcept;

  struct Selected {
    std::uint32_t pixel;  ///< y * width + x
    std::int64_t t_us;
  };
  /// Walks a selection. Thread: any between two add(); several at once. RT: yes.
  class Reader {
   public:
    /// Its first event is number i of the selection, i < s.count.
    Reader(const EventWindow& window, const Selection& s, std::uint32_t i) noexcept;

    /// Precondition: not beyond the selection's end.
    Selected next() noexcept {
      while (left_ <= left_after_) enter(slice_ + 1);
      const std::uint32_t value = window_.value(slot_);
      const std::int64_t t_us = (slice_ << window_.time_bits_) | (value & window_.time_mask_);
      rest_ += step_rest_;
      const std::uint32_t more = rest_ >= count_ ? 1 : 0;
      rest_ -= more != 0 ? count_ : 0;
      left_ -= step_ + more;
      slot_ += step_ + more;
      slot_ -= slot_ >= window_.capacity_ ? window_.capacity_ : 0;
      return {value >> window_.time_bits_, t_us};
    }

   private:
    void enter(std::int64_t slice) noexcept {
      slice_ = slice;
      left_after_ = window_.since_end(slice);
    }

    const EventWindow& window_;
    std::int64_t slice_ = 0;
    std::uint32_t left_;            // events from the next one on, it included
    std::uint32_t left_after_ = 0;  // events after slice_
    std::uint32_t slot_;
    std::uint32_t step_, step_rest_, rest_, count_;  // in_window / count, carried without a division
  };

  /// Time of the newest event; INT64_MIN before the first. Thread: the tick.
  [[nodiscard]] std::int64_t newest_us() const noexcept { return newest_us_; }

 private:
  [[nodiscard]] std::uint32_t value(std::uint32_t slot) const noexcept {
    return low_[slot] | static_cast<std::uint32_t>(high_[slot]) << 16;
  }
  /// Events since the begin of a slice, or its end, and since some number of events: modulo 2^32, far more
  /// than are held. Precondition: the slice is among the newest that there is room for.
  [[nodiscard]] std::uint32_t since_begin(std::int64_t slice) const noexcept {
    return static_cast<std::uint32_t>(added_) - first_of_slice_[index(slice)];
  }
  [[nodiscard]] std::uint32_t since_end(std::int64_t slice) const noexcept {
    return slice == newest_slice_ ? 0 : since_begin(slice + 1);
  }
  [[nodiscard]] std::size_t index(std::int64_t slice) const noexcept {
    return static_cast<std::size_t>(static_cast<std::uint64_t>(slice)) & (first_of_slice_.size() - 1);
  }
  /// Slot of the newest event but `since` - 1. Precondition: 1 <= since <= capacity_.
  [[nodiscard]] std::uint32_t slot_of(std::uint32_t since) const noexcept {
    return next_slot_ >= since ? next_slot_ - since : next_slot_ + (capacity_ - since);
  }

  std::uint32_t max_events_;
  std::uint32_t capacity_;
  std::int64_t max_age_us_;
  std::uint32_t sensor_width_;
  int time_bits_;
  std::uint32_t time_mask_;
  std::span<std::uint16_t> low_;  // pixel << time_bits | time within the slice: the lower 16 bits
  std::span<std::uint8_t> high_;  // the upper 8 bits
  /// Modulo 2^32, of the newest slices, each at its number modulo their count; of a slice without events that
  /// of the next one's. One that is older than the first event has 0.
  std::span<std::uint32_t> first_of_slice_;
  std::uint64_t added_ = 0;
  std::uint32_t next_slot_ = 0;  // added_ modulo capacity_
  std::int64_t newest_slice_ = 0;
  std::int64_t newest_us_ = INT64_MIN;
};

}  // namespace egofocus
