#include "system_calls.hpp"

#include <linux/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>

namespace egofocus::reliability {
namespace {

// close() of what is no descriptor: nothing happens, and nobody else asks for it.
constexpr int kBegin = -1001;
constexpr int kEnd = -1002;

// glibc's name for the request is an enumerator of another type in C++.
long trace(int request, pid_t thread, std::uintptr_t address, void* data) noexcept {
  return ::syscall(SYS_ptrace, request, thread, address, data);
}

bool wait_for_stop(pid_t& thread, int& status) noexcept {
  thread = ::waitpid(-1, &status, __WALL);
  return thread > 0;
}

}  // namespace

void begin_counting() noexcept {
  ::syscall(SYS_close, kBegin);
}
void end_counting() noexcept {
  ::syscall(SYS_close, kEnd);
}

std::map<std::uint64_t, std::uint64_t> count_system_calls(const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (trace(PTRACE_TRACEME, 0, 0, nullptr) != 0) std::_Exit(1);
    ::raise(SIGSTOP);
    std::_Exit(work());
  }
  std::map<std::uint64_t, std::uint64_t> calls;
  bool counting = false;
  bool failed = true;
  pid_t thread = 0;
  for (int status = 0; wait_for_stop(thread, status);) {
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      if (thread != child) continue;
      failed = !WIFEXITED(status) || WEXITSTATUS(status) != 0;
      break;
    }
    int signal = WSTOPSIG(status);
    if (signal == (SIGTRAP | 0x80)) {
      signal = 0;
      ptrace_syscall_info info{};
      if (trace(PTRACE_GET_SYSCALL_INFO, thread, sizeof info, &info) > 0 &&
          info.op == PTRACE_SYSCALL_INFO_ENTRY) {
        const auto first = static_cast<int>(info.entry.args[0]);
        const bool is_mark = info.entry.nr == SYS_close && (first == kBegin || first == kEnd);
        if (is_mark) counting = first == kBegin;
        if (counting && !is_mark) ++calls[info.entry.nr];
      }
    } else if (signal == SIGSTOP || signal == SIGTRAP) {
      signal = 0;
      trace(PTRACE_SETOPTIONS, thread, 0,
            reinterpret_cast<void*>(
                std::uintptr_t{PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_EXITKILL}));
    }
    trace(PTRACE_SYSCALL, thread, 0, reinterpret_cast<void*>(static_cast<std::uintptr_t>(signal)));
  }
  return failed ? std::map<std::uint64_t, std::uint64_t>{} : calls;
}

const char* system_call_name(std::uint64_t number) {
  static std::string other;
  switch (number) {
    case SYS_futex:
      return "futex";
    case SYS_clock_nanosleep:
      return "clock_nanosleep";
    case SYS_clock_gettime:
      return "clock_gettime";
    default:
      return (other = std::to_string(number)).c_str();
  }
}

}  // namespace egofocus::reliability
