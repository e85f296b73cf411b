// What a guest program says: one line for each thing that must be true, and an exit code.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace egofocus::hil {

inline int failures = 0;

inline void expect_at(bool truth, const char* what, int line) {
  std::printf("%s line %d: %s\n", truth ? "ok    " : "FAILED", line, what);
  std::fflush(stdout);
  failures += !truth;
}

/// For steps without which the rest means nothing.
inline void require_at(bool truth, const char* what, int line) {
  expect_at(truth, what, line);
  if (!truth) std::exit(1);
}

}  // namespace egofocus::hil

#define EXPECT(truth) egofocus::hil::expect_at((truth), #truth, __LINE__)
#define REQUIRE(truth) egofocus::hil::require_at((truth), #truth, __LINE__)
