// The system calls of V4L2 and the media controller, as functions that tests can replace.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace egofocus {

/// Each returns what the system call of its name does, or -errno. None blocks but `wait`, which ends after
/// its time at the latest.
struct V4l2Io {
  void* self = nullptr;
  /// For reading and writing, non-blocking, closed on exec.
  int (*open)(void* self, const char* path) noexcept = nullptr;
  int (*close)(void* self, int fd) noexcept = nullptr;
  int (*ioctl)(void* self, int fd, unsigned long request, void* argument) noexcept = nullptr;
  /// Shared, for reading.
  int (*map)(void* self, int fd, std::size_t bytes, std::int64_t offset,
             const std::byte*& memory) noexcept = nullptr;
  int (*unmap)(void* self, const std::byte* memory, std::size_t bytes) noexcept = nullptr;
  /// poll() for input: its revents; 0: nothing came. Without a file (-1) a pause.
  int (*wait)(void* self, int fd, std::int64_t timeout_us) noexcept = nullptr;
  /// The path in /dev of a character device, with a final NUL.
  int (*path_of)(void* self, std::uint32_t major, std::uint32_t minor,
                 std::span<char> out) noexcept = nullptr;
  /// The device number of an open file.
  int (*number_of)(void* self, int fd, std::uint32_t& major, std::uint32_t& minor) noexcept = nullptr;
};

/// The kernel's. Thread: any. RT: yes.
const V4l2Io& system_v4l2_io() noexcept;

}  // namespace egofocus
