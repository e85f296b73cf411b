// How long the stages of a tick take.
#pragma once

#include <cstdint>

#include "core/clock.hpp"

namespace egofocus {

class StageWatch {
 public:
  StageWatch() noexcept
      : clock_(monotonic_clock()), begin_us_(clock_.now_us(clock_.self)), last_us_(begin_us_) {}

  /// Since the last lap, or since the begin. Thread: the tick. RT: yes.
  std::uint32_t lap_us() noexcept {
    const std::int64_t now_us = clock_.now_us(clock_.self);
    const auto lap = static_cast<std::uint32_t>(now_us - last_us_);
    last_us_ = now_us;
    return lap;
  }
  /// From the begin to the last lap.
  [[nodiscard]] std::uint32_t all_us() const noexcept {
    return static_cast<std::uint32_t>(last_us_ - begin_us_);
  }

 private:
  Clock clock_;
  std::int64_t begin_us_;
  std::int64_t last_us_;
};

}  // namespace egofocus
