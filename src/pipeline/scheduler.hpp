// The fixed-rate grid of ticks. Tick k is about t_k = t_0 + k * period and runs at t_k + lateness. The period
// is added to the grid, never to the time at which a tick happened to end: no drift. A tick that comes too
// late takes the next grid point that is not yet due; the points between are counted as skipped, never made
// up for in a burst.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/clock.hpp"
#include "egofocus/config.hpp"
#include "egofocus/status.hpp"

namespace egofocus {

class Scheduler {
 public:
  static Status check(const RateConfig& config) noexcept;

  /// Periods that are no whole number of microseconds are kept exactly: t_k = t_0 + floor(k * 10^6 / rate),
  /// where the quotient is one IEEE division: exact to the microsecond as long as k * 10^6 < 2^53.
  void start(const RateConfig& config, std::int64_t first_tick_us) noexcept;

  [[nodiscard]] std::int64_t tick_us() const noexcept { return at(index_); }
  [[nodiscard]] std::int64_t deadline_us() const noexcept { return tick_us() + lateness_us_; }
  [[nodiscard]] std::uint64_t index() const noexcept { return index_; }

  /// Sleeps to the deadline, or until `stopping` for at most 50 ms more. Returns how long after the deadline
  /// the clock stands then.
  std::int64_t wait(const Clock& clock, const std::atomic<bool>& stopping) noexcept;

  /// Before a tick's work that could only begin too late: moves to the newest grid point whose deadline is
  /// not after `now_us`. Returns the number of points passed over.
  std::uint64_t catch_up(std::int64_t now_us) noexcept;

  /// After the tick's work: moves to the next grid point whose deadline is not before `now_us`. Returns the
  /// number of points passed over.
  std::uint64_t advance(std::int64_t now_us) noexcept;

  /// Virtual time: the next grid point, none is ever skipped.
  void advance() noexcept { ++index_; }

  /// The next tick is about `t_us`, and the grid goes on from there. The index goes on, too.
  void move_to(std::int64_t t_us) noexcept {
    first_us_ = t_us;
    first_index_ = index_;
  }

 private:
  [[nodiscard]] std::int64_t at(std::uint64_t index) const noexcept;

  std::int64_t first_us_ = 0;      // of the grid
  std::uint64_t first_index_ = 0;  // of the tick at first_us_
  double rate_hz_ = 20;
  std::int64_t lateness_us_ = 0;
  std::uint64_t index_ = 0;
};

}  // namespace egofocus
