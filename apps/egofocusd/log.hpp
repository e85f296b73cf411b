// Lines for people on stderr, which is the journal under systemd. Never from a real-time thread.
#pragma once

#include <string_view>

namespace egofocus::daemon {

/// The numbers of syslog, which the journal reads at the beginning of a line.
enum class Priority : int { kError = 3, kWarning = 4, kNotice = 5, kInfo = 6 };

/// At most 20 lines in a row, and 2 a second on average; what is left out is counted, and the next line that
/// comes through says how many. A stderr that takes nothing (a stopped terminal, a stuck journal) loses the
/// line, never time. Thread: the service's and the disk's.
void log(Priority priority, std::string_view text);

/// Lines left out so far: too many, or not taken.
[[nodiscard]] unsigned long long lines_left_out();

}  // namespace egofocus::daemon
