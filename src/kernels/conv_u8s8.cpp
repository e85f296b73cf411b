#include "kernels/conv_u8s8.hpp"

#include "kernels/requant.hpp"

namespace egofocus {
namespace {

std::int32_t sum_at(const ConvU8S8& conv, std::int32_t row, std::int32_t column, std::int32_t o) noexcept {
  const std::int32_t half = conv.side / 2;
  const std::int8_t* weight =
      conv.packed.weights + std::int64_t{o} * conv.depth * conv.side * conv.side * conv.in_channels;
  std::int32_t acc = conv.packed.bias[o];
  for (std::int32_t kz = 0; kz < conv.depth; ++kz) {
    const std::uint8_t* plane = conv.input + (kz - conv.depth / 2) * conv.input_plane_stride;
    for (std::int32_t ky = 0; ky < conv.side; ++ky) {
      for (std::int32_t kx = 0; kx < conv.side; ++kx) {
        const std::int64_t y = row * conv.stride + (ky - half) * conv.dilation;
        const std::int64_t x = column * conv.stride + (kx - half) * conv.dilation;
        const std::uint8_t* pixel = plane + y * conv.input_row_stride + x * conv.input_pixel_stride;
        for (std::int32_t i = 0; i < conv.in_channels; ++i) acc += *weight++ * pixel[i];
      }
    }
  }
  return acc;
}

}  // namespace

void conv_u8s8_scalar(const ConvU8S8& conv) noexcept {
  for (std::int32_t row = conv.first_row; row < conv.first_row + conv.rows; ++row) {
    for (std::int32_t column = 0; column < conv.columns; ++column) {
      std::uint8_t* out = static_cast<std::uint8_t*>(conv.output) +
                          std::int64_t{row} * conv.output_row_stride +
                          std::int64_t{column} * conv.output_pixel_stride;
      for (std::int32_t o = 0; o < conv.out_channels; ++o) {
        const std::int16_t r = requant_s16(sum_at(conv, row, column, o), conv.packed.scale[o]);
        switch (conv.epilogue) {
          case ConvEpilogue::kRelu:
            out[o] = static_cast<std::uint8_t>(clamp_s32(r, 0, 127));
            break;
          case ConvEpilogue::kAdd: {
            const std::uint8_t x = conv.addend[std::int64_t{row} * conv.addend_row_stride +
                                               std::int64_t{column} * conv.addend_pixel_stride + o];
            out[o] = static_cast<std::uint8_t>(clamp_s32(x + r, 0, 127));
            break;
          }
          case ConvEpilogue::kSmall:
            out[o] = static_cast<std::uint8_t>(clamp_s32(r, -128, 127));
            break;
          case ConvEpilogue::kScore:
            reinterpret_cast<std::int16_t*>(out)[o] = r;
            break;
        }
      }
    }
  }
}

}  // namespace egofocus
