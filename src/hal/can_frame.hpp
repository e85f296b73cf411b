// One data frame of a CAN bus, classic or FD.
#pragma once

#include <cstdint>

namespace egofocus {

struct CanFrame {
  std::int64_t t_us = 0;  ///< of reception, on the recorder's clock
  std::uint32_t id = 0;   ///< 11 bits, or 29 bits if `extended`
  bool extended = false;
  bool fd = false;
  std::uint8_t length = 0;  ///< bytes in `data`: 0..8, or 0..64 if `fd`
  std::uint8_t data[64] = {};
};

/// The frames of one kind whose id equals `id` in the bits of `mask`.
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
  bool extended = false;
  [[nodiscard]] bool passes(const CanFrame& frame) const noexcept {
    return frame.extended == extended && ((frame.id ^ id) & mask) == 0;
  }
};

/// Sees frames as they come in, before anything is made of them: for a recorder. No function: nobody looks.
/// Thread: the source's. RT: yes.
struct CanTap {
  void* self = nullptr;
  void (*frame)(void* self, const CanFrame& frame) noexcept = nullptr;
};

}  // namespace egofocus
