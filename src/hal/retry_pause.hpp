// When a lost device is looked for again: 0.1 s, 0.2 s, ... 2 s after each failure.
#pragma once

#include <cstdint>

namespace egofocus {

/// Thread: one. RT: yes.
class RetryPause {
 public:
  void failed(std::int64_t now_us) noexcept {
    pause_us_ = pause_us_ == 0 ? kFirst_us : 2 * pause_us_ < kLongest_us ? 2 * pause_us_ : kLongest_us;
    next_us_ = now_us + pause_us_;
  }
  /// Data came: the next failure is a first one again.
  void worked() noexcept { pause_us_ = 0; }
  [[nodiscard]] std::int64_t next_us() const noexcept { return next_us_; }

 private:
  static constexpr std::int64_t kFirst_us = 100'000;
  static constexpr std::int64_t kLongest_us = 2'000'000;
  std::int64_t pause_us_ = 0;
  std::int64_t next_us_ = 0;
};

}  // namespace egofocus
