#include "hal/v4l2_io.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>

#include "hal/v4l2_text.hpp"

namespace egofocus {
namespace {

int result(long code) noexcept {
  return code < 0 ? -errno : static_cast<int>(code);
}

int open_file(void*, const char* path) noexcept {
  return result(open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC));
}

int close_file(void*, int fd) noexcept {
  return result(close(fd));
}

int control(void*, int fd, unsigned long request, void* argument) noexcept {
  return result(ioctl(fd, request, argument));
}

int map(void*, int fd, std::size_t bytes, std::int64_t offset, const std::byte*& memory) noexcept {
  void* const mapped = mmap(nullptr, bytes, PROT_READ, MAP_SHARED, fd, static_cast<off_t>(offset));
  if (mapped == MAP_FAILED) return -errno;
  memory = static_cast<const std::byte*>(mapped);
  return 0;
}

int unmap(void*, const std::byte* memory, std::size_t bytes) noexcept {
  return result(munmap(const_cast<std::byte*>(memory), bytes));
}

int wait(void*, int fd, std::int64_t timeout_us) noexcept {
  pollfd entry{fd, POLLIN, 0};
  const std::int64_t milliseconds = timeout_us <= 0         ? 0
                                    : timeout_us >= 1000000 ? 1000
                                                            : (timeout_us + 999) / 1000;
  const int code = result(poll(&entry, 1, static_cast<int>(milliseconds)));
  return code <= 0 ? code : entry.revents;
}

// Documentation/ABI/testing/sysfs-dev: /sys/dev/char/MAJOR:MINOR is the device; its uevent names the node.
int path_of(void*, std::uint32_t major_number, std::uint32_t minor_number, std::span<char> out) noexcept {
  char path[64];
  V4l2Text(path).text("/sys/dev/char/").number(major_number).text(":").number(minor_number).text("/uevent");
  const int fd = result(open(path, O_RDONLY | O_CLOEXEC));
  if (fd < 0) return fd;
  char text[1024];
  const int bytes = result(read(fd, text, sizeof text));
  close(fd);
  if (bytes < 0) return bytes;
  std::string_view rest(text, static_cast<std::size_t>(bytes));
  constexpr std::string_view kKey = "DEVNAME=";
  const std::size_t key = rest.find(kKey);
  if (key == std::string_view::npos) return -ENOENT;
  rest.remove_prefix(key + kKey.size());
  V4l2Text(out).text("/dev/").text({rest.data(), std::min(rest.find('\n'), rest.size())});
  return 0;
}

int number_of(void*, int fd, std::uint32_t& major_number, std::uint32_t& minor_number) noexcept {
  struct stat status {};
  if (const int code = result(fstat(fd, &status)); code < 0) return code;
  major_number = major(status.st_rdev);
  minor_number = minor(status.st_rdev);
  return 0;
}

constexpr V4l2Io kSystem = {nullptr, open_file, close_file, control, map, unmap, wait, path_of, number_of};

}  // namespace

const V4l2Io& system_v4l2_io() noexcept {
  return kSystem;
}

}  // namespace egofocus
