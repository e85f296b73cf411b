// The system calls of the SocketCAN source, as functions that tests can replace.
#pragma once

#include <sys/socket.h>

#include <cstdint>

namespace egofocus {

/// Each returns what the system call of its name does, or -errno. None blocks but `wait`, which ends after
/// its time at the latest.
struct SocketCanIo {
  void* self = nullptr;
  /// A raw CAN socket, non-blocking, closed on exec.
  int (*open)(void* self) noexcept = nullptr;
  int (*close)(void* self, int fd) noexcept = nullptr;
  int (*set_option)(void* self, int fd, int level, int option, const void* value,
                    socklen_t bytes) noexcept = nullptr;
  /// The interface's number (above 0).
  int (*index_of)(void* self, int fd, const char* name) noexcept = nullptr;
  int (*bind)(void* self, int fd, int index) noexcept = nullptr;
  /// 1: the interface is up, 0: down.
  int (*is_up)(void* self, int fd, const char* name) noexcept = nullptr;
  int (*set_up)(void* self, int fd, const char* name, bool up) noexcept = nullptr;
  /// poll() for input on `fd`; without one (-1) a pause. 0: nothing came.
  int (*wait)(void* self, int fd, std::int64_t timeout_us) noexcept = nullptr;
  /// recvmmsg() without waiting.
  int (*receive)(void* self, int fd, mmsghdr* messages, unsigned count) noexcept = nullptr;
  /// CLOCK_MONOTONIC or CLOCK_REALTIME, ns.
  std::int64_t (*now_ns)(void* self, bool realtime) noexcept = nullptr;
};

/// The kernel's. Thread: any. RT: yes.
const SocketCanIo& system_socketcan_io() noexcept;

}  // namespace egofocus
