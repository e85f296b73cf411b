// How a variant of conv_u8s8 wants its weights: made once, at set-up, into the caller's memory.
#pragma once

#include <cstdint>

namespace egofocus {

/// The order of packed weights, with T = tile_outputs, G = group_inputs:
///   [ceil(out_channels / T)][depth * side * side][ceil(in_channels / G)][T][G], zeros where there is no
///   channel.
struct ConvPacking {
  std::int32_t tile_outputs = 1;
  std::int32_t group_inputs = 1;
};

/// A layer as the model file has it.
struct ConvWeights {
  const std::int8_t* weights = nullptr;  ///< [out_channels][depth][side][side][source_channels], -127..127
  const std::int32_t* bias = nullptr;    ///< [out_channels]
  const float* scale = nullptr;          ///< [out_channels]
  std::int32_t source_channels = 0;      ///< 1..in_channels / copies; what is missing gets weight 0
  std::int32_t in_channels = 0;          ///< those of the input tensor, padded to a multiple of 4
  std::int32_t out_channels = 0;
  std::int32_t side = 1;
  std::int32_t depth = 1;
  /// The layer so many times beside itself: copy c reads source_channels from channel c * in_channels /
  /// copies on, and writes outputs c * out_channels and the following. Divides in_channels.
  std::int32_t copies = 1;
};

/// Views into the memory that pack_conv_u8s8 filled; bias and scale end with zeros up to a whole tile.
struct PackedConv {
  const std::int8_t* weights = nullptr;
  const std::int32_t* bias = nullptr;
  const float* scale = nullptr;
};

inline constexpr std::int64_t kConvPackedAlignment = 64;

/// Bytes that pack_conv_u8s8 needs: a multiple of kConvPackedAlignment. Uses only the layer's sizes.
/// Thread: any. RT: set-up only.
std::int64_t conv_packed_bytes(const ConvPacking& packing, const ConvWeights& layer) noexcept;

/// Fills memory, conv_packed_bytes() long and aligned to kConvPackedAlignment. Thread: any. RT: set-up only.
PackedConv pack_conv_u8s8(const ConvPacking& packing, const ConvWeights& layer, void* memory) noexcept;

}  // namespace egofocus
