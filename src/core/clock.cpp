#include "core/clock.hpp"

#include <cerrno>
#include <ctime>

namespace egofocus {
namespace {

constexpr std::int64_t kMicroPerSecond = 1000000;

std::int64_t monotonic_now(void*) noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * kMicroPerSecond + now.tv_nsec / 1000;
}

void monotonic_sleep(void*, std::int64_t t_us) noexcept {
  timespec until{};
  until.tv_sec = static_cast<time_t>(t_us / kMicroPerSecond);
  until.tv_nsec = static_cast<long>(t_us % kMicroPerSecond) * 1000;
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace

Clock monotonic_clock() noexcept {
  return {nullptr, monotonic_now, monotonic_sleep};
}

Clock VirtualClock::clock() noexcept {
  return {this, [](void* self) noexcept { return static_cast<VirtualClock*>(self)->now_us_; },
          [](void* self, std::int64_t t_us) noexcept {
            auto& now = static_cast<VirtualClock*>(self)->now_us_;
            if (t_us > now) now = t_us;
          }};
}

}  // namespace egofocus
