// Injected time. Two users: the monotonic clock of the host, and a virtual one that replay and tests set.
#pragma once

#include <cstdint>

namespace egofocus {

/// A clock and its two functions. `sleep_until_us` returns at or after the time. Thread: any. RT: yes (the
/// sleep is bounded by its argument).
struct Clock {
  void* self = nullptr;
  std::int64_t (*now_us)(void* self) noexcept = nullptr;
  void (*sleep_until_us)(void* self, std::int64_t t_us) noexcept = nullptr;
};

/// CLOCK_MONOTONIC with absolute sleeps (clock_nanosleep, TIMER_ABSTIME), so that a period never drifts.
Clock monotonic_clock() noexcept;

/// Time that stands still until someone moves it; sleeping moves it.
class VirtualClock {
 public:
  [[nodiscard]] std::int64_t now_us() const noexcept { return now_us_; }
  void set(std::int64_t t_us) noexcept { now_us_ = t_us; }
  Clock clock() noexcept;

 private:
  std::int64_t now_us_ = 0;
};

}  // namespace egofocus
