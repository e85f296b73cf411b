// Do ticks still come? What the watchdog is told depends on it.
#pragma once

#include <algorithm>
#include <cstdint>

namespace egofocus::daemon {

class TickWatch {
 public:
  /// `period_us` of the ticks; three of them, or 2 s, may pass without one.
  void begin(std::int64_t period_us, std::int64_t now_us) noexcept {
    patience_us_ = std::max<std::int64_t>(3 * period_us, 2'000'000);
    seen_us_ = now_us;
  }

  /// `ticks` so far. False: none has come for too long.
  [[nodiscard]] bool is_alive(std::uint64_t ticks, std::int64_t now_us) noexcept {
    if (ticks != ticks_) {
      ticks_ = ticks;
      seen_us_ = now_us;
    }
    return now_us - seen_us_ <= patience_us_;
  }

 private:
  std::int64_t patience_us_ = 0;
  std::int64_t seen_us_ = 0;
  std::uint64_t ticks_ = 0;
};

}  // namespace egofocus::daemon
