#include "pipeline/model_bytes.hpp"

namespace egofocus {
namespace {

struct CrcTable {
  constexpr CrcTable() noexcept {
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t crc = i;
      for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320u : 0u);
      entry[i] = crc;
    }
  }
  std::uint32_t entry[256] = {};
};
constexpr CrcTable kCrcTable;

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes) noexcept {
  std::uint32_t crc = 0xffffffffu;
  for (const std::byte byte : bytes)
    crc = (crc >> 8) ^ kCrcTable.entry[(crc ^ static_cast<std::uint32_t>(byte)) & 0xffu];
  return ~crc;
}

}  // namespace egofocus
