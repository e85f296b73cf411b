// Which system calls a piece of a program makes, on all its threads, as the kernel sees them.
#pragma once

#include <cstdint>
#include <functional>
#include <map>

namespace egofocus::reliability {

/// In the child of count_system_calls(): what lies between counts. Costs a system call each; RT: no.
void begin_counting() noexcept;
void end_counting() noexcept;

/// Runs `work` in a child process under ptrace. Returns the number of calls by system call number; empty when
/// the system does not permit it, or the child failed. Linux 5.3.
[[nodiscard]] std::map<std::uint64_t, std::uint64_t> count_system_calls(const std::function<int()>& work);

/// "futex", or its number as text.
[[nodiscard]] const char* system_call_name(std::uint64_t number);

}  // namespace egofocus::reliability
