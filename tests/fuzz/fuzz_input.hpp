// What the fuzzers share: traps and a reader of the input's first bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/types.hpp"

namespace fuzz {

inline void require(bool condition) {
  if (!condition) __builtin_trap();
}

inline bool same(const egofocus::Event& a, const egofocus::Event& b) {
  return a.t_us == b.t_us && a.x == b.x && a.y == b.y && a.polarity == b.polarity;
}

/// Takes the first byte off `bytes`; 0 when there is none.
inline std::uint8_t take_byte(std::span<const std::byte>& bytes) {
  if (bytes.empty()) return 0;
  const std::uint8_t value = std::to_integer<std::uint8_t>(bytes.front());
  bytes = bytes.subspan(1);
  return value;
}

}  // namespace fuzz
