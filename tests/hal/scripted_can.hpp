// A CAN socket of a kernel that does what a test says: interfaces that come and go, messages, errors, clocks.
#pragma once

#include <linux/can.h>
#include <linux/errqueue.h>
#include <net/if.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "hal/socketcan_io.hpp"

namespace egofocus::test {

// What a recvmmsg() gives next: a message, or an errno.
struct Scripted {
  int error = 0;
  canfd_frame frame{};
  unsigned bytes = CAN_MTU;
  std::int64_t software_ns = 0;
  std::int64_t hardware_ns = 0;
  std::int64_t drops = -1;  // SO_RXQ_OVFL, where >= 0
  bool truncated = false;
};

class ScriptedCan {
 public:
  struct Interface {
    int index = 0;
    bool up = true;
    bool is_can = true;
  };

  std::map<std::string, Interface> interfaces{{"can0", {3}}};
  std::deque<Scripted> queue;
  std::int64_t monotonic_ns = 5'000'000'000;
  std::int64_t realtime_ns = 1'700'000'000'000'000'000;
  std::int64_t waited_us = 0;
  int open_sockets = 0;
  int opened = 0;
  int calls = 0;  // all of them
  int waits = 0;
  int bound_index = 0;
  std::map<int, std::vector<unsigned char>> options;  // by option
  std::map<int, int> refused_options;                 // option -> errno
  int open_error = 0;
  int bind_error = 0;
  int set_up_error = 0;
  std::deque<int> wait_errors;
  std::vector<bool> links_set;

  void pass(std::int64_t us) {
    monotonic_ns += us * 1000;
    realtime_ns += us * 1000;
  }

  // A data frame that the kernel stamped now.
  Scripted& frame(std::uint32_t id, std::initializer_list<int> bytes) {
    Scripted next;
    next.frame.can_id = id;
    next.frame.len = static_cast<std::uint8_t>(bytes.size());
    std::size_t i = 0;
    for (const int byte : bytes) next.frame.data[i++] = static_cast<std::uint8_t>(byte);
    next.software_ns = realtime_ns;
    queue.push_back(next);
    return queue.back();
  }
  Scripted& error_frame(std::uint32_t classes, std::initializer_list<int> bytes) {
    return frame(classes | CAN_ERR_FLAG, bytes);
  }
  void fail(int error) { queue.push_back({.error = error}); }

  SocketCanIo io() {
    SocketCanIo io;
    io.self = this;
    io.open = [](void* self) noexcept { return of(self).do_open(); };
    io.close = [](void* self, int) noexcept {
      --of(self).open_sockets;
      return 0;
    };
    io.set_option = [](void* self, int, int, int option, const void* value, socklen_t bytes) noexcept {
      ScriptedCan& s = of(self);
      if (const auto refused = s.refused_options.find(option); refused != s.refused_options.end())
        return -refused->second;
      const auto* first = static_cast<const unsigned char*>(value);
      s.options[option].assign(first, first + bytes);
      return 0;
    };
    io.index_of = [](void* self, int, const char* name) noexcept {
      ScriptedCan& s = of(self);
      const auto found = s.interfaces.find(name);
      return found == s.interfaces.end() ? -ENODEV : found->second.index;
    };
    io.bind = [](void* self, int, int index) noexcept { return of(self).do_bind(index); };
    io.is_up = [](void* self, int, const char* name) noexcept {
      ScriptedCan& s = of(self);
      const auto found = s.interfaces.find(name);
      return found == s.interfaces.end() ? -ENODEV : static_cast<int>(found->second.up);
    };
    io.set_up = [](void* self, int, const char* name, bool up) noexcept {
      ScriptedCan& s = of(self);
      if (s.set_up_error != 0) return -s.set_up_error;
      s.interfaces[name].up = up;
      s.links_set.push_back(up);
      if (!up) s.fail(ENETDOWN);
      return 0;
    };
    io.wait = [](void* self, int fd, std::int64_t timeout_us) noexcept {
      return of(self).do_wait(fd, timeout_us);
    };
    io.receive = [](void* self, int, mmsghdr* messages, unsigned count) noexcept {
      return of(self).do_receive(messages, count);
    };
    io.now_ns = [](void* self, bool realtime) noexcept {
      return realtime ? of(self).realtime_ns : of(self).monotonic_ns;
    };
    return io;
  }

 private:
  static ScriptedCan& of(void* self) {
    auto& s = *static_cast<ScriptedCan*>(self);
    ++s.calls;
    return s;
  }
  int do_open() {
    if (open_error != 0) return -open_error;
    ++open_sockets;
    return 100 + opened++;
  }
  int do_bind(int index) {
    if (bind_error != 0) return -bind_error;
    for (const auto& [name, interface] : interfaces) {
      if (interface.index == index && !interface.is_can) return -ENODEV;
    }
    bound_index = index;
    return 0;
  }
  int do_wait(int fd, std::int64_t timeout_us) {
    ++waits;
    if (!wait_errors.empty()) {
      const int error = wait_errors.front();
      wait_errors.pop_front();
      return -error;
    }
    if (fd >= 0 && !queue.empty()) return 1;
    waited_us += timeout_us;
    pass(timeout_us);
    return 0;
  }
  int do_receive(mmsghdr* messages, unsigned count) {
    unsigned done = 0;
    while (done < count && !queue.empty()) {
      if (queue.front().error != 0) {
        if (done > 0) return static_cast<int>(done);  // the kernel keeps it for the next call
        const int error = queue.front().error;
        queue.pop_front();
        return -error;
      }
      deliver(queue.front(), messages[done++]);
      queue.pop_front();
    }
    return done > 0 ? static_cast<int>(done) : -EAGAIN;
  }
  static void deliver(const Scripted& from, mmsghdr& to) {
    const std::size_t bytes =
        from.bytes < to.msg_hdr.msg_iov->iov_len ? from.bytes : to.msg_hdr.msg_iov->iov_len;
    std::memcpy(to.msg_hdr.msg_iov->iov_base, &from.frame, bytes);
    to.msg_len = static_cast<unsigned>(bytes);
    to.msg_hdr.msg_flags = from.truncated ? MSG_TRUNC : 0;
    std::memset(to.msg_hdr.msg_control, 0, to.msg_hdr.msg_controllen);
    std::size_t used = 0;
    cmsghdr* c = CMSG_FIRSTHDR(&to.msg_hdr);
    if (from.drops >= 0) {
      const auto drops = static_cast<std::uint32_t>(from.drops);
      c->cmsg_level = SOL_SOCKET;
      c->cmsg_type = SO_RXQ_OVFL;
      c->cmsg_len = CMSG_LEN(sizeof drops);
      std::memcpy(CMSG_DATA(c), &drops, sizeof drops);
      used += CMSG_SPACE(sizeof drops);
      c = reinterpret_cast<cmsghdr*>(static_cast<unsigned char*>(to.msg_hdr.msg_control) + used);
    }
    if (from.software_ns != 0 || from.hardware_ns != 0) {
      const auto spec = [](std::int64_t ns) {
        timespec t{};
        t.tv_sec = static_cast<time_t>(ns / 1000000000);
        t.tv_nsec = static_cast<long>(ns % 1000000000);
        return t;
      };
      const timespec times[3] = {spec(from.software_ns), {}, spec(from.hardware_ns)};
      c->cmsg_level = SOL_SOCKET;
      c->cmsg_type = SCM_TIMESTAMPING;
      c->cmsg_len = CMSG_LEN(sizeof times);
      std::memcpy(CMSG_DATA(c), times, sizeof times);
      used += CMSG_SPACE(sizeof times);
    }
    to.msg_hdr.msg_controllen = used;
  }
};

}  // namespace egofocus::test
