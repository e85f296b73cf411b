// Little-endian numbers of a model file, and its check sum.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace egofocus {

/// Precondition: the bytes exist.
inline std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}
inline double read_f64(std::span<const std::byte> bytes, std::size_t at) noexcept {
  const std::uint64_t high = read_u32(bytes, at + 4);
  return std::bit_cast<double>((high << 32) | read_u32(bytes, at));
}

/// CRC-32 of IEEE 802.3 (reflected 0xedb88320, all ones before and after), as zlib and PNG have it.
std::uint32_t crc32(std::span<const std::byte> bytes) noexcept;

}  // namespace egofocus
