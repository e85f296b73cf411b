#include "kernels/depthwise_u8s8_packing.hpp"

#include <cstring>

namespace egofocus {
namespace {

constexpr std::int64_t aligned(std::int64_t bytes) noexcept {
  return (bytes + kConvPackedAlignment - 1) / kConvPackedAlignment * kConvPackedAlignment;
}

struct PackedSizes {
  std::int64_t weights;      // bytes, aligned
  std::int64_t per_channel;  // bytes of bias, and of scale, aligned
};

PackedSizes sizes_of(const DepthwisePacking& packing, std::int32_t channels) noexcept {
  const std::int64_t blocks = depthwise_blocks(packing, channels);
  return {aligned(blocks * depthwise_block_bytes(packing)), aligned(blocks * packing.block_channels * 4)};
}

}  // namespace

DepthwisePlace depthwise_place(const DepthwisePacking& packing, std::int32_t n) noexcept {
  const std::int32_t width = packing.block_channels;
  const std::int64_t block = n / width;
  const std::int32_t in_block = n % width;
  const bool interleaved = packing.by_columns && width >= 16;
  const std::int32_t at =
      interleaved ? in_block % 16 / 4 * (width / 4) + in_block / 16 * 4 + in_block % 4 : in_block;
  DepthwisePlace place{};
  place.of_channel = block * width + at;
  for (std::int32_t tap = 0; tap < 9; ++tap) {
    const std::int32_t in_taps = packing.by_columns ? (tap % 3 * width + at) * 4 + tap / 3 : tap * width + at;
    place.of_tap[tap] = block * depthwise_block_bytes(packing) + in_taps;
  }
  return place;
}

std::int64_t depthwise_packed_bytes(const DepthwisePacking& packing, std::int32_t channels) noexcept {
  const PackedSizes sizes = sizes_of(packing, channels);
  return sizes.weights + 2 * sizes.per_channel;
}

PackedConv pack_depthwise_u8s8(const DepthwisePacking& packing, const DepthwiseWeights& layer,
                               void* memory) noexcept {
  const PackedSizes sizes = sizes_of(packing, layer.channels);
  std::memset(memory, 0, static_cast<std::size_t>(sizes.weights + 2 * sizes.per_channel));
  std::int8_t* const weights = static_cast<std::int8_t*>(memory);
  std::int32_t* const bias = reinterpret_cast<std::int32_t*>(weights + sizes.weights);
  float* const scale = reinterpret_cast<float*>(weights + sizes.weights + sizes.per_channel);
  const std::int32_t bytes = depthwise_blocks(packing, layer.channels) * packing.block_channels;
  const std::int32_t to_row_below = 12 * packing.block_channels + 1;
  for (std::int32_t n = 0; n < bytes; ++n) {
    const std::int32_t c = n % layer.channels;
    const DepthwisePlace at = depthwise_place(packing, n);
    for (std::int32_t tap = 0; tap < 9; ++tap) {
      const std::int8_t w = layer.weights[9 * c + tap];
      weights[at.of_tap[tap]] = w;
      if (packing.by_columns) weights[at.of_tap[tap] + to_row_below] = w;
    }
    bias[at.of_channel] = layer.bias[c];
    scale[at.of_channel] = layer.scale[c];
  }
  return {weights, bias, scale};
}

}  // namespace egofocus
