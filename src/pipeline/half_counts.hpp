// Counts of cells of 2x2 pixels as the network's refinement wants them: at most 15, so two share a byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace egofocus {

inline constexpr std::uint8_t kMostHalfCounts = 15;

/// Bytes of one plane of so many cells.
constexpr std::size_t half_counts_bytes(std::size_t cells) noexcept {
  return (cells + 1) / 2;
}

/// counts: [cells]; out: half_counts_bytes(cells); an odd last cell has a zero beside it. Thread: any. RT:
/// yes.
inline void pack_half_counts(std::span<const std::uint8_t> counts, std::uint8_t* out) noexcept {
  const auto capped = [](std::uint8_t count) noexcept {
    return count < kMostHalfCounts ? count : kMostHalfCounts;
  };
  const std::uint8_t* const from = counts.data();
  std::uint8_t* __restrict const to = out;
  const std::size_t whole = counts.size() / 2;
  for (std::size_t i = 0; i < whole; ++i)
    to[i] = static_cast<std::uint8_t>(capped(from[2 * i]) | capped(from[2 * i + 1]) << 4);
  if (whole * 2 < counts.size()) to[whole] = capped(from[2 * whole]);
}

inline std::uint8_t half_count(const std::uint8_t* plane, std::size_t cell) noexcept {
  return static_cast<std::uint8_t>((plane[cell / 2] >> (cell % 2 * 4)) & 15);
}

}  // namespace egofocus
