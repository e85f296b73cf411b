// How much memory of this process is in RAM.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>

// Sanitizers keep what was freed.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define EGOFOCUS_RESIDENT_MEMORY_IS_OURS false
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define EGOFOCUS_RESIDENT_MEMORY_IS_OURS false
#endif
#endif
#ifndef EGOFOCUS_RESIDENT_MEMORY_IS_OURS
#define EGOFOCUS_RESIDENT_MEMORY_IS_OURS true
#endif

namespace egofocus::reliability {

/// All of the program's code and data, so that what is used for the first time later does not look like
/// growth. Without the right to lock memory it does.
inline void make_program_resident() {
  if (::mlockall(MCL_CURRENT) == 0) ::munlockall();
}

inline std::int64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::int64_t all = 0;
  std::int64_t resident = 0;
  file >> all >> resident;
  return resident * ::sysconf(_SC_PAGESIZE);
}

}  // namespace egofocus::reliability
