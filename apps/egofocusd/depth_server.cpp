#include "depth_server.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace egofocus::daemon {
namespace {

constexpr int kNeverWait = MSG_DONTWAIT | MSG_NOSIGNAL;

bool hand_over(int reader, int descriptor) noexcept {
  char hello = 'D';
  iovec part{&hello, 1};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  cmsghdr* carried = CMSG_FIRSTHDR(&message);
  carried->cmsg_level = SOL_SOCKET;
  carried->cmsg_type = SCM_RIGHTS;
  carried->cmsg_len = CMSG_LEN(sizeof(int));
  std::memcpy(CMSG_DATA(carried), &descriptor, sizeof descriptor);
  return ::sendmsg(reader, &message, kNeverWait) == 1;
}

// A reader has nothing to say: what it sends is read and forgotten.
bool is_gone(int reader) noexcept {
  char bytes[64];
  const ssize_t got = ::recv(reader, bytes, sizeof bytes, MSG_DONTWAIT);
  return got == 0 || (got < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
}

}  // namespace

DepthServer::DepthServer(const SocketConfig& config) : socket_(config.socket, SOCK_SEQPACKET, config.group) {}

void DepthServer::show(const DepthMemory* memory) {
  if (memory != memory_) readers_.clear();
  memory_ = memory;
}

void DepthServer::serve() {
  std::erase_if(readers_, [](const Descriptor& reader) { return is_gone(reader.number()); });
  if (memory_ == nullptr) return;  // they wait in the queue
  for (Descriptor reader = socket_.accept(); reader.is_open(); reader = socket_.accept()) {
    if (readers_.size() < kMostReaders && hand_over(reader.number(), memory_->descriptor()))
      readers_.push_back(std::move(reader));
  }
}

void DepthServer::wake_readers() {
  for (const Descriptor& reader : readers_) static_cast<void>(::send(reader.number(), "n", 1, kNeverWait));
}

void DepthServer::add_to(std::vector<pollfd>& watched) const {
  if (memory_ != nullptr) watched.push_back({socket_.number(), POLLIN, 0});
  for (const Descriptor& reader : readers_) watched.push_back({reader.number(), POLLIN, 0});
}

}  // namespace egofocus::daemon
