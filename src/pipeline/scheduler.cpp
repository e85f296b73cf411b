#include "pipeline/scheduler.hpp"

#include "core/elementary.hpp"

namespace egofocus {
namespace {

constexpr std::int64_t kLongestSleep_us = 50'000;

}  // namespace

Status Scheduler::check(const RateConfig& config) noexcept {
  if (!(config.rate_hz >= 0.1 && config.rate_hz <= 1000)) {
    return {StatusCode::kBadRate, "rate.rate_hz (0.1..1000)", status_value(config.rate_hz), 1000};
  }
  if (config.lateness_us < 0 || config.lateness_us > 1'000'000) {
    return {StatusCode::kBadRate, "rate.lateness_us", config.lateness_us, 1'000'000};
  }
  if (config.max_late_us < 0 || config.max_late_us > 10'000'000) {
    return {StatusCode::kBadRate, "rate.max_late_us", config.max_late_us, 10'000'000};
  }
  return {};
}

void Scheduler::start(const RateConfig& config, std::int64_t first_tick_us) noexcept {
  first_us_ = first_tick_us;
  rate_hz_ = config.rate_hz;
  lateness_us_ = config.lateness_us;
  first_index_ = 0;
  index_ = 0;
}

// One division per tick, no sum of rounded periods: an error cannot add up.
std::int64_t Scheduler::at(std::uint64_t index) const noexcept {
  const auto periods = static_cast<double>(index - first_index_);
  return first_us_ + static_cast<std::int64_t>(floor_of(periods * 1e6 / rate_hz_));
}

std::int64_t Scheduler::wait(const Clock& clock, const std::atomic<bool>& stopping) noexcept {
  const std::int64_t until_us = deadline_us();
  for (std::int64_t now_us = clock.now_us(clock.self); now_us < until_us; now_us = clock.now_us(clock.self)) {
    if (stopping.load(std::memory_order_relaxed)) break;
    clock.sleep_until_us(clock.self,
                         until_us - now_us > kLongestSleep_us ? now_us + kLongestSleep_us : until_us);
  }
  return clock.now_us(clock.self) - until_us;
}

std::uint64_t Scheduler::catch_up(std::int64_t now_us) noexcept {
  const std::uint64_t before = index_;
  const std::uint64_t passed = advance(now_us);
  // advance() goes on to a point that is not yet due, and at least by one.
  index_ = before + passed;
  if (at(index_ + 1) + lateness_us_ <= now_us) ++index_;
  return index_ - before;
}

std::uint64_t Scheduler::advance(std::int64_t now_us) noexcept {
  ++index_;
  if (deadline_us() >= now_us) return 0;
  const std::uint64_t before = index_;
  const auto behind_us = static_cast<double>(now_us - lateness_us_ - first_us_);
  const auto last_due = first_index_ + static_cast<std::uint64_t>(floor_of(behind_us * rate_hz_ * 1e-6));
  if (last_due > index_ + 1) index_ = last_due - 1;  // the quotient's rounding may be one too high
  while (deadline_us() < now_us) ++index_;           // at most three steps
  return index_ - before;
}

}  // namespace egofocus
