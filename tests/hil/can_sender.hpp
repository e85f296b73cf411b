// Sends recorded frames on a CAN interface.
#pragma once

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "hal/can_frame.hpp"

namespace egofocus::hil {

class CanSender {
 public:
  /// is_open() says whether there is such an interface.
  explicit CanSender(const char* interface_name) : fd_(socket(PF_CAN, SOCK_RAW, CAN_RAW)) {
    const int on = 1;
    (void)setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0);
    (void)setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface_name));
    is_open_ = address.can_ifindex != 0 &&
               bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~CanSender() { close(fd_); }
  CanSender(const CanSender&) = delete;
  CanSender& operator=(const CanSender&) = delete;

  [[nodiscard]] bool is_open() const { return is_open_; }

  /// Waits while the interface's queue is full. False: the interface takes nothing any more.
  bool send(const CanFrame& frame) const {
    canfd_frame wire{};
    wire.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0);
    wire.len = frame.length;
    std::memcpy(wire.data, frame.data, frame.length);
    const std::size_t bytes = frame.fd ? CANFD_MTU : CAN_MTU;
    while (write(fd_, &wire, bytes) < 0) {
      if (errno != ENOBUFS && errno != EINTR) return false;
      usleep(500);
    }
    return true;
  }

 private:
  int fd_;
  bool is_open_ = false;
};

}  // namespace egofocus::hil
