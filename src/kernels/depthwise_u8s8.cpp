#include "kernels/depthwise_u8s8.hpp"

#include "kernels/requant.hpp"

namespace egofocus {
namespace {

std::int32_t sum_at(const DepthwiseU8S8& conv, std::int32_t row, std::int32_t column,
                    std::int32_t c) noexcept {
  std::int32_t acc = conv.packed.bias[c];
  for (std::int32_t ky = 0; ky < 3; ++ky) {
    for (std::int32_t kx = 0; kx < 3; ++kx) {
      const std::int64_t y = row * conv.stride + (ky - 1) * conv.dilation;
      const std::int64_t x = column * conv.stride + (kx - 1) * conv.dilation;
      const std::uint8_t* pixel = conv.input + y * conv.input_row_stride + x * conv.input_pixel_stride;
      acc += conv.packed.weights[9 * c + 3 * ky + kx] * pixel[c];
    }
  }
  return acc;
}

}  // namespace

void depthwise_u8s8_scalar(const DepthwiseU8S8& conv) noexcept {
  for (std::int32_t row = conv.first_row; row < conv.first_row + conv.rows; ++row) {
    for (std::int32_t column = 0; column < conv.columns; ++column) {
      std::uint8_t* out = conv.output + std::int64_t{row} * conv.output_row_stride +
                          std::int64_t{column} * conv.output_pixel_stride;
      for (std::int32_t c = 0; c < conv.channels; ++c) {
        const std::int16_t r = requant_s16(sum_at(conv, row, column, c), conv.packed.scale[c]);
        if (conv.epilogue == ConvEpilogue::kAdd) {
          const std::uint8_t x = conv.addend[std::int64_t{row} * conv.addend_row_stride +
                                             std::int64_t{column} * conv.addend_pixel_stride + c];
          out[c] = static_cast<std::uint8_t>(clamp_s32(x + r, 0, 127));
        } else {
          const std::int32_t least = conv.epilogue == ConvEpilogue::kSmall ? -128 : 0;
          out[c] = static_cast<std::uint8_t>(clamp_s32(r, least, 127));
        }
      }
    }
  }
}

}  // namespace egofocus
