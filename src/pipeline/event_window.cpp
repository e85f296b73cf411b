#include "pipeline/event_window.hpp"

#include "core/check.hpp"
#include "pipeline/fixed_point.hpp"

namespace egofocus {
namespace {

constexpr int kEventBits = 24;

std::uint32_t pixels(const Intrinsics& sensor) noexcept {
  return static_cast<std::uint32_t>(sensor.width_px) * static_cast<std::uint32_t>(sensor.height_px);
}

int bits_of(std::uint32_t most) noexcept {
  return static_cast<int>(bit_width_u32(most));
}

}  // namespace

Status EventWindow::check(const WindowConfig& config) noexcept {
  if (config.max_events < 100 || config.max_events > 1'000'000) {
    return {StatusCode::kBadWindow, "window.max_events", config.max_events, 1'000'000};
  }
  if (config.min_events < 0 || config.min_events > config.max_events) {
    return {StatusCode::kBadWindow, "window.min_events", config.min_events, config.max_events};
  }
  if (config.max_age_us < 1000 || config.max_age_us > 1'000'000) {
    return {StatusCode::kBadWindow, "window.max_age_us", config.max_age_us, 1'000'000};
  }
  return {};
}

EventWindow::EventWindow(const WindowConfig& config, const Intrinsics& sensor, Arena& arena) noexcept
    : max_events_(static_cast<std::uint32_t>(config.max_events)),
      capacity_(max_events_ * 4),
      max_age_us_(config.max_age_us),
      sensor_width_(static_cast<std::uint32_t>(sensor.width_px)),
      time_bits_(kEventBits - bits_of(pixels(sensor) - 1)),
      time_mask_((1u << time_bits_) - 1),
      low_(arena.array<std::uint16_t>(capacity_)),
      high_(arena.array<std::uint8_t>(capacity_)) {
  // Those of max_age_us, begun or ended within it, and the next one.
  const auto slices = static_cast<std::uint32_t>((max_age_us_ >> time_bits_) + 3);
  first_of_slice_ = arena.array<std::uint32_t>(std::size_t{1} << bits_of(slices - 1));
}

void EventWindow::add(const Event& event) noexcept {
  const std::int64_t slice = event.t_us >> time_bits_;
  if (added_ == 0) newest_slice_ = slice;
  const auto room = static_cast<std::int64_t>(first_of_slice_.size());
  std::int64_t s = newest_slice_ < slice - room ? slice - room : newest_slice_;
  while (s < slice) first_of_slice_[index(++s)] = static_cast<std::uint32_t>(added_);
  newest_slice_ = slice;
  newest_us_ = event.t_us;
  const std::uint32_t pixel = event.y * sensor_width_ + event.x;
  const std::uint32_t value = pixel << time_bits_ | (static_cast<std::uint32_t>(event.t_us) & time_mask_);
  low_[next_slot_] = static_cast<std::uint16_t>(value);
  high_[next_slot_] = static_cast<std::uint8_t>(value >> 16);
  ++added_;
  if (++next_slot_ == capacity_) next_slot_ = 0;
}

EventWindow::Selection EventWindow::select(std::int64_t begin_us, std::int64_t end_us) const noexcept {
  const std::int64_t oldest_us = begin_us > end_us - max_age_us_ ? begin_us : end_us - max_age_us_;
  if (added_ == 0 || newest_us_ < oldest_us || newest_us_ > end_us) return {};
  const std::int64_t slice = oldest_us >> time_bits_;
  // Of the oldest slice those that are too old are left out: young ones are its last.
  std::uint32_t young = since_end(slice);
  std::uint32_t all = since_begin(slice);
  if (all > capacity_) all = capacity_;
  const std::uint32_t oldest_low = static_cast<std::uint32_t>(oldest_us) & time_mask_;
  if (young > all) young = all;
  while (young < all) {
    const std::uint32_t middle = all - (all - young) / 2;
    if ((value(slot_of(middle)) & time_mask_) >= oldest_low) {
      young = middle;
    } else {
      all = middle - 1;
    }
  }
  Selection s;
  s.first = added_ - young;
  s.in_window = young;
  s.count = young < max_events_ ? young : max_events_;
  return s;
}

EventWindow::Reader::Reader(const EventWindow& window, const Selection& s, std::uint32_t i) noexcept
    : window_(window), count_(s.count) {
  EGOFOCUS_CHECK(i < s.count);
  const std::uint64_t offset = i * s.in_window / s.count;
  rest_ = static_cast<std::uint32_t>(i * s.in_window % s.count);
  step_ = static_cast<std::uint32_t>(s.in_window / s.count);
  step_rest_ = static_cast<std::uint32_t>(s.in_window % s.count);
  left_ = static_cast<std::uint32_t>(window.added_ - (s.first + offset));
  slot_ = window.slot_of(left_);
  // The newest slice that begins no later than with this event.
  std::int64_t begun = window.newest_slice_ + 1 - static_cast<std::int64_t>(window.first_of_slice_.size());
  std::int64_t beyond = window.newest_slice_ + 1;
  while (beyond - begun > 1) {
    const std::int64_t middle = begun + (beyond - begun) / 2;
    (window.since_begin(middle) >= left_ ? begun : beyond) = middle;
  }
  enter(begun);
}

}  // namespace egofocus
