#include "simulated_time.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <ctime>

namespace egofocus::reliability {
namespace {

std::int64_t now_us = 1'000'000;

}  // namespace

void set_time_us(std::int64_t t_us) noexcept {
  now_us = t_us;
}
std::int64_t time_us() noexcept {
  return now_us;
}

}  // namespace egofocus::reliability

// In front of the C library's, for the library is linked into this program.
extern "C" {
int clock_gettime(clockid_t clock, timespec* out) noexcept {
  if (clock != CLOCK_MONOTONIC) return static_cast<int>(::syscall(SYS_clock_gettime, clock, out));
  out->tv_sec = static_cast<time_t>(egofocus::reliability::now_us / 1'000'000);
  out->tv_nsec = static_cast<long>(egofocus::reliability::now_us % 1'000'000) * 1000;
  return 0;
}

int clock_nanosleep(clockid_t, int, const timespec* until, timespec*) {
  egofocus::reliability::now_us =
      static_cast<std::int64_t>(until->tv_sec) * 1'000'000 + until->tv_nsec / 1000;
  return 0;
}
}
