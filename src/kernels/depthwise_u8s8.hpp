// Depthwise 3x3 convolution in integers: each channel by itself, as the fixed gradient filters are too.
// Numbers, rounding and ways to leave are conv_u8s8's (docs/integer_model.md). Channels lie innermost (NHWC).
#pragma once

#include <cstdint>

#include "kernels/conv_u8s8.hpp"
#include "kernels/depthwise_u8s8_packing.hpp"

namespace egofocus {

/// Operands of one call. For each output row y in [first_row, first_row + rows), column x in [0, columns) and
/// channel c in [0, channels), with w[c][ky][kx] the packed weights and s32 sums:
///   acc = bias[c] + sum over ky, kx in 0..2 of
///         w[c][ky][kx] * in(y * stride + (ky - 1) * dilation, x * stride + (kx - 1) * dilation)[c]
///   out(y, x)[c] = epilogue(requant_s16(acc, scale[c]), addend(y, x)[c])
/// where t(y, x) = t + y * t_row_stride + x * t_pixel_stride. The kernel knows no border and no zero point:
/// what the formula reads beyond the edges is there, filled with the zero point by the caller, and
/// -zero * sum w is in the bias already.
///
/// Ranges (the caller's duty; nothing overflows then): bytes of input and addend 0..127; weights -127..127;
/// |bias| <= 2^30; 2^-40 <= scale < 1; channels a multiple of 4, 4..4096; stride 1 or 2; dilation 1..4; any
/// epilogue but kScore; columns, rows and first_row >= 0; strides >= 0, in bytes. Rows, columns and pixels
/// may overlap in memory only as input. Over-read: none. Over-write: none: the bytes between the pixels'
/// channels are left alone. Alignment: packed memory 64 bytes. Aliasing: the output overlaps nothing, but may
/// be the addend itself, with its strides.
struct DepthwiseU8S8 {
  const std::uint8_t* input = nullptr;   ///< pixel (0, 0) of the interior, not of the border
  std::int32_t input_row_stride = 0;     ///< bytes
  std::int32_t input_pixel_stride = 0;   ///< bytes
  const std::uint8_t* addend = nullptr;  ///< kAdd only
  std::int32_t addend_row_stride = 0;    ///< bytes
  std::int32_t addend_pixel_stride = 0;  ///< bytes
  std::uint8_t* output = nullptr;        ///< u8 or s8: see ConvEpilogue
  std::int32_t output_row_stride = 0;    ///< bytes
  std::int32_t output_pixel_stride = 0;  ///< bytes
  PackedConv packed;                     ///< by the DepthwisePacking of the very variant that runs
  std::int32_t channels = 0;
  std::int32_t stride = 1;
  std::int32_t dilation = 1;
  ConvEpilogue epilogue = ConvEpilogue::kRelu;
  std::int32_t columns = 0;    ///< of the output
  std::int32_t first_row = 0;  ///< of the output; a share of the rows for one of several threads
  std::int32_t rows = 0;
};

/// Thread: any; calls that write different rows may run at once. RT: yes, O(rows * columns * channels).
using DepthwiseU8S8Function = void(const DepthwiseU8S8& conv) noexcept;

#define EGOFOCUS_DEPTHWISE_U8S8(suffix, isa, block_channels, by_columns) \
  DepthwiseU8S8Function depthwise_u8s8_##suffix;                         \
  inline constexpr DepthwisePacking kDepthwisePacking_##suffix{block_channels, by_columns};
#include "kernels/depthwise_u8s8.inc"
#undef EGOFOCUS_DEPTHWISE_U8S8

}  // namespace egofocus
