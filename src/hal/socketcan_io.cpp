#include "hal/socketcan_io.hpp"

#include <linux/can.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>

namespace egofocus {
namespace {

int result(long code) noexcept {
  return code < 0 ? -errno : static_cast<int>(code);
}

ifreq request_for(const char* name) noexcept {
  ifreq request{};
  for (std::size_t i = 0; i + 1 < sizeof request.ifr_name && name[i] != '\0'; ++i)
    request.ifr_name[i] = name[i];
  return request;
}

int open_socket(void*) noexcept {
  return result(socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
}

int close_socket(void*, int fd) noexcept {
  return result(close(fd));
}

int set_option(void*, int fd, int level, int option, const void* value, socklen_t bytes) noexcept {
  return result(setsockopt(fd, level, option, value, bytes));
}

int index_of(void*, int fd, const char* name) noexcept {
  ifreq request = request_for(name);
  const int code = result(ioctl(fd, SIOCGIFINDEX, &request));
  return code < 0 ? code : request.ifr_ifindex;
}

int bind_to(void*, int fd, int index) noexcept {
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  return result(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address));
}

int is_up(void*, int fd, const char* name) noexcept {
  ifreq request = request_for(name);
  const int code = result(ioctl(fd, SIOCGIFFLAGS, &request));
  return code < 0 ? code : (request.ifr_flags & IFF_UP) != 0;
}

int set_up(void*, int fd, const char* name, bool up) noexcept {
  ifreq request = request_for(name);
  const int code = result(ioctl(fd, SIOCGIFFLAGS, &request));
  if (code < 0) return code;
  const int flags = up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP;
  request.ifr_flags = static_cast<short>(flags);
  return result(ioctl(fd, SIOCSIFFLAGS, &request));
}

int wait(void*, int fd, std::int64_t timeout_us) noexcept {
  pollfd entry{fd, POLLIN, 0};
  const std::int64_t milliseconds = timeout_us <= 0         ? 0
                                    : timeout_us >= 1000000 ? 1000
                                                            : (timeout_us + 999) / 1000;
  return result(poll(&entry, 1, static_cast<int>(milliseconds)));
}

int receive(void*, int fd, mmsghdr* messages, unsigned count) noexcept {
  return result(recvmmsg(fd, messages, count, MSG_DONTWAIT, nullptr));
}

std::int64_t now_ns(void*, bool realtime) noexcept {
  timespec now{};
  clock_gettime(realtime ? CLOCK_REALTIME : CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1000000000 + now.tv_nsec;
}

constexpr SocketCanIo kSystem = {nullptr, open_socket, close_socket, set_option, index_of, bind_to,
                                 is_up,   set_up,      wait,         receive,    now_ns};

}  // namespace

const SocketCanIo& system_socketcan_io() noexcept {
  return kSystem;
}

}  // namespace egofocus
