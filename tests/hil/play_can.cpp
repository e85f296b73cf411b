// Plays a candump log onto a CAN interface at the speed at which it was recorded.
//
//   hil_play_can LOG INTERFACE
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/clock.hpp"
#include "hal/candump_decoder.hpp"
#include "hil/can_sender.hpp"

using namespace egofocus;

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: hil_play_can LOG INTERFACE\n", stderr);
    return 2;
  }
  std::ifstream file(argv[1], std::ios::binary);
  const std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
  std::span<const std::byte> left = std::as_bytes(std::span(text));
  const hil::CanSender bus(argv[2]);
  if (!file.good() || !bus.is_open()) {
    std::perror(bus.is_open() ? argv[1] : argv[2]);
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
    if (!bus.send(frame)) {
      std::perror(argv[2]);
      return 3;
    }
    ++sent;
  }
  std::printf("%lu frames sent, at worst %lld us late\n", sent, static_cast<long long>(latest_us));
  return sent > 0 ? 0 : 4;
}
