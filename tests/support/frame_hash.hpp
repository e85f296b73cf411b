// One number for all that a depth frame says: FNV-1a over its fields, byte by byte, little end first.
#pragma once

#include <cstdint>

#include "egofocus/types.hpp"

namespace egofocus::test {

class FrameHash {
 public:
  void add(const DepthFrame& frame) noexcept {
    add(static_cast<std::uint64_t>(frame.t_us), 8);
    add(static_cast<std::uint64_t>(frame.age_us), 8);
    add(frame.sequence, 8);
    add(frame.flags, 4);
    add(frame.events, 4);
    add(frame.votes, 8);
    add(bits(frame.inverse_depth_scale_per_m), 8);
    add(bits(frame.parallax_px), 8);
    for (double v : frame.velocity_m_s) add(bits(v), 8);
    for (std::uint16_t v : frame.inverse_depth) add(v, 2);
    for (std::uint8_t v : frame.confidence) add(v, 1);
  }
  [[nodiscard]] std::uint64_t value() const noexcept { return value_; }

 private:
  static std::uint64_t bits(double x) noexcept {
    std::uint64_t out;
    static_assert(sizeof(out) == sizeof(x));
    __builtin_memcpy(&out, &x, sizeof(out));
    return out;
  }
  void add(std::uint64_t v, int bytes) noexcept {
    for (int i = 0; i < bytes; ++i) {
      value_ ^= (v >> (8 * i)) & 0xff;
      value_ *= 0x100000001b3u;
    }
  }
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace egofocus::test
