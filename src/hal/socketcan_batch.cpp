#include "hal/socketcan_batch.hpp"

#include <linux/can.h>
#include <linux/errqueue.h>

#include <cstring>
#include <ctime>

namespace egofocus {
namespace {

static_assert(CAN_MTU == 16 && CANFD_MTU == 72);

std::int64_t nanoseconds(const timespec& t) noexcept {
  return static_cast<std::int64_t>(t.tv_sec) * 1000000000 + t.tv_nsec;
}

void read_control(const msghdr& header, CanMessage& message) noexcept {
  msghdr copy = header;  // the macros want it writable
  for (cmsghdr* c = CMSG_FIRSTHDR(&copy); c != nullptr; c = CMSG_NXTHDR(&copy, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SCM_TIMESTAMPING && c->cmsg_len >= CMSG_LEN(3 * sizeof(timespec))) {
      timespec times[3];
      std::memcpy(times, CMSG_DATA(c), sizeof times);
      message.software_ns = nanoseconds(times[0]);
      message.hardware_ns = nanoseconds(times[2]);
    } else if (c->cmsg_type == SO_RXQ_OVFL && c->cmsg_len >= CMSG_LEN(sizeof message.drops)) {
      std::memcpy(&message.drops, CMSG_DATA(c), sizeof message.drops);
      message.has_drops = true;
    }
  }
}

}  // namespace

mmsghdr* SocketCanBatch::prepare() noexcept {
  for (unsigned i = 0; i < kMessages; ++i) {
    vectors_[i] = {frames_[i], kFrameBytes};
    headers_[i] = {};
    headers_[i].msg_hdr.msg_iov = &vectors_[i];
    headers_[i].msg_hdr.msg_iovlen = 1;
    headers_[i].msg_hdr.msg_control = controls_[i];
    headers_[i].msg_hdr.msg_controllen = kControlBytes;
  }
  return headers_;
}

CanMessage SocketCanBatch::message(unsigned i) const noexcept {
  CanMessage result;
  const mmsghdr& header = headers_[i];
  read_control(header.msg_hdr, result);
  const bool fd = header.msg_len == CANFD_MTU;
  if ((!fd && header.msg_len != CAN_MTU) || (header.msg_hdr.msg_flags & MSG_TRUNC) != 0) return result;

  canfd_frame wire{};
  std::memcpy(&wire, frames_[i], fd ? CANFD_MTU : CAN_MTU);
  if (wire.len > (fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN)) return result;
  const bool error = (wire.can_id & CAN_ERR_FLAG) != 0;
  const bool remote = (wire.can_id & CAN_RTR_FLAG) != 0;
  result.kind = error    ? CanMessage::Kind::kError
                : remote ? CanMessage::Kind::kRemote
                         : CanMessage::Kind::kData;
  CanFrame& frame = result.frame;
  frame.extended = !error && (wire.can_id & CAN_EFF_FLAG) != 0;
  frame.id = wire.can_id & (error || frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.fd = fd;
  frame.length = wire.len;
  std::memcpy(frame.data, wire.data, wire.len);
  return result;
}

}  // namespace egofocus
