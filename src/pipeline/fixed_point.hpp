// Integer square root and logarithm: what fixed-point statistics need beside + - *. Each has one value, said
// exactly, so that any body of it gives the same bits. Thread: any. RT: yes.
#pragma once

#include <cstdint>

namespace egofocus {

/// Number of significant bits: 0 for 0, 32 from 2^31 on.
inline std::uint32_t bit_width_u32(std::uint32_t x) noexcept {
  return x == 0 ? 0 : 32 - static_cast<std::uint32_t>(__builtin_clz(x));
}

/// floor(a b / 2^32)
inline std::uint32_t multiply_high_u32(std::uint32_t a, std::uint32_t b) noexcept {
  return static_cast<std::uint32_t>((static_cast<std::uint64_t>(a) * b) >> 32);
}

/// floor(sqrt(x)). A loop over it has no branches.
inline std::uint32_t floor_square_root_u32(std::uint32_t x) noexcept {
  // IEEE's root of x as binary32 is within 0.01 of x's: at most one beside it when cut off, and 65536 where
  // the conversion rounds up to 2^32. Exact from here on, whatever it was.
  const auto near = static_cast<std::int32_t>(__builtin_sqrtf(static_cast<float>(x)));
  std::uint32_t root = near < 65535 ? static_cast<std::uint32_t>(near) : 65535u;
  root -= root * root > x ? 1u : 0u;
  root += x - root * root > 2 * root ? 1u : 0u;
  return root;
}

/// 256 log2(1 + (i + 1/2) / 256), rounded half up, i < 256.
struct Log2Table {
  constexpr Log2Table() noexcept {
    for (int i = 0; i < 256; ++i) {
      // Bit by bit: squaring doubles the logarithm. 24 bits are far from every half.
      double x = 1.0 + (i + 0.5) / 256.0;
      std::uint32_t log2_q24 = 0;
      for (int bit = 23; bit >= 0; --bit) {
        x *= x;
        if (x >= 2.0) {
          x *= 0.5;
          log2_q24 |= 1u << bit;
        }
      }
      entry_q8[i] = static_cast<std::uint16_t>((log2_q24 + (1u << 15)) >> 16);
    }
  }
  std::uint16_t entry_q8[256] = {};
};
inline constexpr Log2Table kLog2Table;

/// 256 log2(x) from the eight bits after the leading one, within 1.3. Precondition: x > 0.
inline std::uint32_t log2_q8(std::uint32_t x) noexcept {
  const auto zeros = static_cast<std::uint32_t>(__builtin_clz(x));
  return (31 - zeros) * 256 + kLog2Table.entry_q8[((x << zeros) >> 23) & 255];
}

}  // namespace egofocus
