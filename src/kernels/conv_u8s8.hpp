// Dense convolution in integers over rows and columns, and over planes of them: the network's layers
// (docs/integer_model.md, "Tensors, weights and the one rounding rule"). Channels lie innermost (NHWC,
// NDHWC). A call makes one output plane.
#pragma once

#include <cstdint>

#include "kernels/conv_u8s8_packing.hpp"

namespace egofocus {

/// How a sum leaves, r = requant_s16(acc, scale[o]) of requant.hpp.
enum class ConvEpilogue : std::uint8_t {
  kRelu,   ///< u8 clamp(r, 0, 127)
  kAdd,    ///< u8 clamp(addend + r, 0, 127)
  kSmall,  ///< s8 clamp(r, -128, 127)
  kScore,  ///< s16 r
};

/// Operands of one call. For each output row y in [first_row, first_row + rows), column x in [0, columns) and
/// channel o in [0, out_channels), with w[o][kz][ky][kx][i] the packed weights, h = side / 2, d = depth / 2
/// and s32 sums:
///   acc = bias[o] + sum over kz in [0, depth), ky, kx in [0, side), i in [0, in_channels) of
///         w[o][kz][ky][kx][i] *
///         in(kz - d, y * stride + (ky - h) * dilation, x * stride + (kx - h) * dilation)[i]
///   out(y, x)[o] = epilogue(requant_s16(acc, scale[o]), addend(y, x)[o])
/// where t(z, y, x) = t + z * t_plane_stride + y * t_row_stride + x * t_pixel_stride. The kernel knows no
/// border and no zero point: what the formula reads left of column 0, above row 0, before the first plane and
/// beyond the last ones is there, filled with the zero point by the caller, and -zero * sum w is in the bias
/// already.
///
/// Ranges (the caller's duty; nothing overflows then): bytes of input and addend 0..127; weights -127..127;
/// |bias| <= 2^30; 2^-40 <= scale < 1; in_channels a multiple of 4, 4..4096; 1 <= out_channels <= 4096; side
/// 1 or 3; depth 1 or 3; stride 1 or 2; dilation 1..4; columns, rows and first_row >= 0; strides >= 0, in
/// bytes, those of an s16 output even. Rows, columns and pixels may overlap in memory only as input.
/// Over-read: none: of each pixel that the formula names the in_channels bytes, of each addend the
/// out_channels. Over-write: none: the bytes between the pixels' channels are left alone. Alignment: packed
/// memory 64 bytes; input, addend and output that of their elements. Aliasing: the output overlaps nothing,
/// but may be the addend itself, with its strides. Padded input channels (weights zero) may hold any byte
/// 0..127.
struct ConvU8S8 {
  const std::uint8_t* input = nullptr;   ///< pixel (0, 0) of the interior, not of the border
  std::int32_t input_row_stride = 0;     ///< bytes
  std::int32_t input_pixel_stride = 0;   ///< bytes
  std::int64_t input_plane_stride = 0;   ///< bytes; depth 3 only
  const std::uint8_t* addend = nullptr;  ///< kAdd only
  std::int32_t addend_row_stride = 0;    ///< bytes
  std::int32_t addend_pixel_stride = 0;  ///< bytes
  void* output = nullptr;                ///< u8, s8 or s16: see ConvEpilogue
  std::int32_t output_row_stride = 0;    ///< bytes
  std::int32_t output_pixel_stride = 0;  ///< bytes
  PackedConv packed;                     ///< by the ConvPacking of the very variant that runs
  std::int32_t in_channels = 0;
  std::int32_t out_channels = 0;
  std::int32_t side = 1;
  std::int32_t depth = 1;  ///< planes of the window
  std::int32_t stride = 1;
  std::int32_t dilation = 1;
  ConvEpilogue epilogue = ConvEpilogue::kRelu;
  bool zeros_beyond = false;   ///< all that is read above row 0 and from input_rows on: a body may skip it
  std::int32_t columns = 0;    ///< of the output
  std::int32_t first_row = 0;  ///< of the output; a share of the rows for one of several threads
  std::int32_t rows = 0;
  std::int32_t input_rows = 0;  ///< with zeros_beyond only
};

/// Thread: any; calls that write different rows may run at once. RT: yes, O(rows * columns * out_channels *
/// in_channels * side^2 * depth).
using ConvU8S8Function = void(const ConvU8S8& conv) noexcept;

#define EGOFOCUS_CONV_U8S8(suffix, isa, tile_outputs, group_inputs) \
  ConvU8S8Function conv_u8s8_##suffix;                              \
  inline constexpr ConvPacking kConvPacking_##suffix{tile_outputs, group_inputs};
#include "kernels/conv_u8s8.inc"
#undef EGOFOCUS_CONV_U8S8

}  // namespace egofocus
