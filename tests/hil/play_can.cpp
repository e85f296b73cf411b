// Plays a candump log onto a CAN interface at the speed at which it was recorded.
//
//   hil_play_can LOG INTERFACE
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/clock.hpp"
#include "hal/candump_decoder.hpp"

namespace {

using namespace egofocus;

int open_bus(const char* interface_name) {
  const int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  const int on = 1;
  (void)setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0);
  (void)setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(interface_name));
  return bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? fd : -1;
}

bool send(int fd, const CanFrame& frame) {
  canfd_frame wire{};
  wire.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0);
  wire.len = frame.length;
  std::memcpy(wire.data, frame.data, frame.length);
  const std::size_t bytes = frame.fd ? CANFD_MTU : CAN_MTU;
  while (write(fd, &wire, bytes) < 0) {
    if (errno != ENOBUFS && errno != EINTR) return false;
    usleep(500);  // the interface's queue is full
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: hil_play_can LOG INTERFACE\n", stderr);
    return 2;
  }
  std::ifstream file(argv[1], std::ios::binary);
  const std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
  std::span<const std::byte> left = std::as_bytes(std::span(text));
  const int fd = open_bus(argv[2]);
  if (!file.good() || fd < 0) {
    std::perror(fd < 0 ? argv[2] : argv[1]);
    return 3;
  }
  const Clock clock = monotonic_clock();
  CandumpDecoder log;
  CanFrame frame;
  std::int64_t begin_us = INT64_MIN, latest_us = 0;
  unsigned long sent = 0;
  while (!left.empty()) {
    Decoded done = log.feed(left, {&frame, 1});
    if (done.consumed == 0) done = log.finish(left, {&frame, 1});
    left = left.subspan(done.consumed);
    if (done.produced == 0) continue;
    if (begin_us == INT64_MIN) begin_us = clock.now_us(clock.self) - frame.t_us;
    clock.sleep_until_us(clock.self, begin_us + frame.t_us);
    const std::int64_t late_us = clock.now_us(clock.self) - begin_us - frame.t_us;
    if (late_us > latest_us) latest_us = late_us;
    if (!send(fd, frame)) {
      std::perror(argv[2]);
      return 3;
    }
    ++sent;
  }
  std::printf("%lu frames sent, at worst %lld us late\n", sent, static_cast<long long>(latest_us));
  return sent > 0 ? 0 : 4;
}
