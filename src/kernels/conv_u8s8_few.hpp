// Convolutions with few inputs and outputs: with outputs in lanes most of a 512-bit register would be idle.
// Here a register holds the bytes of neighbouring pixels as they lie in memory, and each output has its own
// sums. Inner to the avx512vnni body.
#pragma once

#include "kernels/conv_u8s8.hpp"

namespace egofocus {

/// 4, 8 or 16 inputs without gaps between pixels, stride 1, at most 8 outputs, nothing to add to.
static inline bool conv_has_few(const ConvU8S8& conv) noexcept {
  const bool inputs = conv.in_channels == 4 || conv.in_channels == 8 || conv.in_channels == 16;
  return inputs && conv.input_pixel_stride == conv.in_channels && conv.stride == 1 &&
         conv.out_channels <= 8 && conv.epilogue != ConvEpilogue::kAdd;
}

void conv_u8s8_few_avx512vnni(const ConvU8S8& conv) noexcept;

}  // namespace egofocus
