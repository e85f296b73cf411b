#include "recording/lzf.hpp"

namespace egofocus::recording {

std::optional<std::size_t> unpack_lzf(std::span<const std::uint8_t> packed,
                                      std::span<std::uint8_t> out) noexcept {
  std::size_t in = 0;
  std::size_t used = 0;
  while (in < packed.size()) {
    const std::size_t control = packed[in++];
    if (control < 32) {
      const std::size_t count = control + 1;
      if (count > packed.size() - in || count > out.size() - used) return {};
      for (std::size_t i = 0; i < count; ++i) out[used++] = packed[in++];
      continue;
    }
    std::size_t count = (control >> 5) + 2;
    if (count == 9) {
      if (in == packed.size()) return {};
      count += packed[in++];
    }
    if (in == packed.size()) return {};
    const std::size_t back = ((control & 31) << 8 | packed[in++]) + 1;
    if (back > used || count > out.size() - used) return {};
    // Byte by byte: a copy may overlap what it writes, which repeats it.
    for (std::size_t i = 0; i < count; ++i, ++used) out[used] = out[used - back];
  }
  return used;
}

}  // namespace egofocus::recording
