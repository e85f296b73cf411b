#include "pipeline/event_window.hpp"

namespace egofocus {

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

EventWindow::EventWindow(const WindowConfig& config, Arena& arena) noexcept
    : max_events_(static_cast<std::uint32_t>(config.max_events)),
      max_age_us_(config.max_age_us),
      events_(arena.array<WindowEvent>(static_cast<std::size_t>(config.max_events) * 4)) {}

void EventWindow::add(const Event& event) noexcept {
  // No window reaches across such a gap.
  if (newest_us_ < event.t_us - max_age_us_) whole_from_ = added_;
  events_[static_cast<std::size_t>(added_ % events_.size())] = WindowEvent(event);
  ++added_;
  newest_us_ = event.t_us;
}

EventWindow::Selection EventWindow::select(std::int64_t begin_us, std::int64_t end_us) const noexcept {
  if (added_ == 0 || newest_us_ < begin_us || newest_us_ > end_us) return {};
  const std::int64_t oldest_us = begin_us > end_us - max_age_us_ ? begin_us : end_us - max_age_us_;
  const auto longest = static_cast<std::uint32_t>(end_us - oldest_us);
  // Walk back until an event is too old. Stored times wrap, but none of long ago can look young: since
  // whole_from_ two neighbours are at most max_age_us apart, so the walk meets an age between `longest` and
  // 2 * max_age_us, far below 2^26, before ages wrap.
  const std::uint64_t since_gap = added_ - whole_from_;
  const std::uint64_t held = since_gap < events_.size() ? since_gap : events_.size();
  std::uint64_t count = 0;
  while (count < held) {
    const WindowEvent& event = events_[static_cast<std::size_t>((added_ - 1 - count) % events_.size())];
    if (age_us(event, end_us) > longest) break;
    ++count;
  }
  Selection s;
  s.first = added_ - count;
  s.in_window = count;
  s.count = static_cast<std::uint32_t>(count < max_events_ ? count : max_events_);
  return s;
}

}  // namespace egofocus
