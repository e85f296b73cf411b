// Signals as something to read. Made before any other thread, so that none of them is interrupted.
#pragma once

#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>

#include "descriptor.hpp"

namespace egofocus::daemon {

/// SIGTERM, SIGINT and SIGHUP wait here; a write to a closed socket or beyond a limit is an errno. Thread:
/// the service's.
class Signals {
 public:
  Signals() {
    sigset_t ours;
    sigemptyset(&ours);
    sigaddset(&ours, SIGTERM);
    sigaddset(&ours, SIGINT);
    sigaddset(&ours, SIGHUP);
    ::pthread_sigmask(SIG_BLOCK, &ours, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    waiting_ = Descriptor(::signalfd(-1, &ours, SFD_NONBLOCK | SFD_CLOEXEC));
  }

  /// The next one's number; 0: none waits.
  [[nodiscard]] int take() const noexcept {
    signalfd_siginfo info{};
    return ::read(waiting_.number(), &info, sizeof info) == sizeof info ? static_cast<int>(info.ssi_signo)
                                                                        : 0;
  }
  [[nodiscard]] int number() const noexcept { return waiting_.number(); }

 private:
  Descriptor waiting_;
};

}  // namespace egofocus::daemon
