// How a variant of depthwise_u8s8 wants its weights: made once, at set-up, into the caller's memory.
#pragma once

#include <cstdint>

#include "kernels/conv_u8s8_packing.hpp"

namespace egofocus {

/// Blocks of B = block_channels bytes in a run of pixels without gaps: position n of block b is of channel
/// (b B + n) mod C. Their weights repeat after C / gcd(B, C) blocks, which are the packed ones. Within a
/// block:
///   by rows of taps:     [ky][kx][B]
///   by columns of taps:  [2][kx][B][4], w[c][ky][kx] at ky of the four in the first half and at ky + 1 in
///   the
///                        second, of the row below; the fourth is zero
/// By columns, positions (and those of bias and scale) are in the order that interleaving four rows within
/// 128 bits leaves: n' = [q][l][j] for n = 16 l + 4 q + j, j < 4. B is then 8 or a multiple of 16.
struct DepthwisePacking {
  std::int32_t block_channels = 1;
  bool by_columns = false;
};

/// A layer as a model has it.
struct DepthwiseWeights {
  const std::int8_t* weights = nullptr;  ///< [channels][3][3], -127..127
  const std::int32_t* bias = nullptr;    ///< [channels]
  const float* scale = nullptr;          ///< [channels]
  std::int32_t channels = 0;
};

/// How many blocks are packed. Thread: any. RT: yes.
constexpr std::int32_t depthwise_blocks(const DepthwisePacking& packing, std::int32_t channels) noexcept {
  std::int32_t a = packing.block_channels;
  std::int32_t b = channels;
  while (b != 0) {
    const std::int32_t rest = a % b;
    a = b;
    b = rest;
  }
  return channels / a;
}

/// Bytes of weights in a block.
constexpr std::int32_t depthwise_block_bytes(const DepthwisePacking& packing) noexcept {
  return (packing.by_columns ? 24 : 9) * packing.block_channels;
}

/// Where a packed layer has what belongs to a run's byte n (channel n mod C).
struct DepthwisePlace {
  std::int64_t of_tap[9];   ///< among the weights; by columns the first half's
  std::int64_t of_channel;  ///< among bias and scale
};
/// Thread: any. RT: set-up only.
DepthwisePlace depthwise_place(const DepthwisePacking& packing, std::int32_t n) noexcept;

/// Bytes that pack_depthwise_u8s8 needs: a multiple of kConvPackedAlignment. Thread: any. RT: set-up only.
std::int64_t depthwise_packed_bytes(const DepthwisePacking& packing, std::int32_t channels) noexcept;

/// Fills memory, depthwise_packed_bytes() long and aligned to kConvPackedAlignment. Thread: any. RT: set-up
/// only.
PackedConv pack_depthwise_u8s8(const DepthwisePacking& packing, const DepthwiseWeights& layer,
                               void* memory) noexcept;

}  // namespace egofocus
