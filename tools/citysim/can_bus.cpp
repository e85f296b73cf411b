#include "citysim/can_bus.hpp"

#include <algorithm>
#include <queue>
#include <stdexcept>

#include "hal/candump_writer.hpp"

namespace egofocus::citysim {
namespace {

/// What arbitration compares: 11 bits, then (29-bit ids lose against 11-bit ones) the rest.
std::uint64_t rank(const CanFrame& frame) {
  return frame.extended ? (std::uint64_t{frame.id} << 1 | 1) : std::uint64_t{frame.id} << 19;
}

}  // namespace

std::int64_t frame_time_us(const CanFrame& frame, int bits_per_s) {
  const int bits = (frame.extended ? 67 : 47) + 8 * frame.length;
  const int stuffed = bits + (bits - 13) / 12;
  return (std::int64_t{stuffed} * 1000000 + bits_per_s - 1) / bits_per_s;
}

std::vector<CanFrame> arbitrated(std::vector<CanFrame> ready, int bits_per_s, std::int64_t& busy_us) {
  std::stable_sort(ready.begin(), ready.end(),
                   [](const CanFrame& a, const CanFrame& b) { return a.t_us < b.t_us; });
  const auto later = [&](std::size_t a, std::size_t b) {
    const std::uint64_t rank_a = rank(ready[a]);
    const std::uint64_t rank_b = rank(ready[b]);
    return rank_a != rank_b ? rank_a > rank_b : a > b;
  };
  std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(later)> waiting(later);
  std::vector<CanFrame> wire;
  std::int64_t free_us = 0;
  busy_us = 0;
  for (std::size_t next = 0; next < ready.size() || !waiting.empty();) {
    if (waiting.empty()) free_us = std::max(free_us, ready[next].t_us);
    while (next < ready.size() && ready[next].t_us <= free_us) waiting.push(next++);
    CanFrame frame = ready[waiting.top()];
    waiting.pop();
    const std::int64_t time_us = frame_time_us(frame, bits_per_s);
    busy_us += time_us;
    free_us += time_us;
    frame.t_us = free_us;
    wire.push_back(frame);
  }
  return wire;
}

std::string candump_text(std::span<const CanFrame> frames, const char* interface_name) {
  std::string text;
  char line[kMaxCandumpLineBytes];
  for (const CanFrame& frame : frames) {
    const std::size_t size = write_candump_line(frame, interface_name, line);
    if (size == 0) throw std::invalid_argument("not a CAN frame: its time, id or length is out of range");
    text.append(line, size);
  }
  return text;
}

}  // namespace egofocus::citysim
