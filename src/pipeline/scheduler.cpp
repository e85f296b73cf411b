#include "pipeline/scheduler.hpp"

#include "core/elementary.hpp"

namespace egofocus {

Status Scheduler::check(const RateConfig& config) noexcept {
  if (!(config.rate_hz >= 0.1 && config.rate_hz <= 1000)) {
    return {StatusCode::kBadRate, "rate.rate_hz (0.1..1000)", static_cast<std::int64_t>(config.rate_hz),
            1000};
  }
  if (config.lateness_us < 0 || config.lateness_us > 1'000'000) {
    return {StatusCode::kBadRate, "rate.lateness_us", config.lateness_us, 1'000'000};
  }
  return {};
}

void Scheduler::start(const RateConfig& config, std::int64_t first_tick_us) noexcept {
  first_us_ = first_tick_us;
  period_ns_ = static_cast<std::int64_t>(floor_of(1e9 / config.rate_hz + 0.5));
  lateness_us_ = config.lateness_us;
  index_ = 0;
}

// 2^63 ns are 292 years: the product does not overflow.
std::int64_t Scheduler::at(std::uint64_t index) const noexcept {
  return first_us_ + static_cast<std::int64_t>(index) * period_ns_ / 1000;
}

std::int64_t Scheduler::wait(const Clock& clock) noexcept {
  if (clock.now_us(clock.self) < deadline_us()) clock.sleep_until_us(clock.self, deadline_us());
  return clock.now_us(clock.self) - deadline_us();
}

std::uint64_t Scheduler::advance(std::int64_t now_us) noexcept {
  ++index_;
  if (deadline_us() >= now_us) return 0;
  const std::uint64_t before = index_;
  const std::int64_t behind_us = now_us - lateness_us_ - first_us_;
  index_ = static_cast<std::uint64_t>((behind_us * 1000 + period_ns_ - 1) / period_ns_);
  while (deadline_us() < now_us) ++index_;  // at most one step: floor to microseconds
  return index_ - before;
}

}  // namespace egofocus
