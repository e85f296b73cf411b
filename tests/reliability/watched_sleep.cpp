#include "watched_sleep.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

namespace {

thread_local std::int64_t late_ns = 0;

std::int64_t ns_of(const timespec& t) noexcept {
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

}  // namespace

namespace egofocus::reliability {

std::int64_t woke_late_ns() noexcept {
  return late_ns;
}

}  // namespace egofocus::reliability

// In front of the C library's, for the library is linked into this program.
extern "C" int clock_nanosleep(clockid_t clock, int flags, const timespec* until, timespec* left) {
  if (::syscall(SYS_clock_nanosleep, clock, flags, until, left) != 0) return errno;
  timespec now{};
  clock_gettime(clock, &now);
  late_ns = ns_of(now) - ns_of(*until);
  return 0;
}
