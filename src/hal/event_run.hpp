// Which events at the head of a span can share one vector of pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/types.hpp"

namespace egofocus {

struct EventRun {
  std::size_t events = 1;
  std::uint32_t mask = 1;  ///< bit i: pixel first_x + i
};

/// Events from the first one on with its time, row and polarity, x strictly rising (a decoder gives vectors
/// out in that order) and within first_x .. first_x + 31. Precondition: `events` is not empty, first_x <= its
/// first x < first_x + 32. Thread: any. RT: yes, at most 32 steps.
inline EventRun run_from(std::span<const Event> events, std::uint32_t first_x) noexcept {
  const Event& first = events[0];
  EventRun run{.events = 1, .mask = 1u << (first.x - first_x)};
  while (run.events < events.size()) {
    const Event& next = events[run.events];
    const bool same_row = next.t_us == first.t_us && next.y == first.y && next.polarity == first.polarity;
    if (!same_row || next.x <= events[run.events - 1].x || next.x >= first_x + 32) break;
    run.mask |= 1u << (next.x - first_x);
    ++run.events;
  }
  return run;
}

}  // namespace egofocus
