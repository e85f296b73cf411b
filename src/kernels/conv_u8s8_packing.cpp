#include "kernels/conv_u8s8_packing.hpp"

#include <cstring>

namespace egofocus {
namespace {

constexpr std::int64_t whole(std::int64_t count, std::int64_t unit) noexcept {
  return (count + unit - 1) / unit * unit;
}

struct PackedSizes {
  std::int64_t taps;
  std::int64_t outputs;      // padded to whole tiles
  std::int64_t inputs;       // padded to whole groups
  std::int64_t weights;      // bytes, aligned
  std::int64_t per_channel;  // bytes of bias, and of scale, aligned
};

PackedSizes sizes_of(const ConvPacking& packing, const ConvWeights& layer) noexcept {
  PackedSizes sizes{};
  sizes.taps = std::int64_t{layer.depth} * layer.side * layer.side;
  sizes.outputs = whole(std::int64_t{layer.copies} * layer.out_channels, packing.tile_outputs);
  sizes.inputs = whole(layer.in_channels, packing.group_inputs);
  sizes.weights = whole(sizes.outputs * sizes.taps * sizes.inputs, kConvPackedAlignment);
  sizes.per_channel = whole(sizes.outputs * 4, kConvPackedAlignment);
  return sizes;
}

}  // namespace

std::int64_t conv_packed_bytes(const ConvPacking& packing, const ConvWeights& layer) noexcept {
  const PackedSizes sizes = sizes_of(packing, layer);
  return sizes.weights + 2 * sizes.per_channel;
}

PackedConv pack_conv_u8s8(const ConvPacking& packing, const ConvWeights& layer, void* memory) noexcept {
  const PackedSizes sizes = sizes_of(packing, layer);
  std::memset(memory, 0, static_cast<std::size_t>(sizes.weights + 2 * sizes.per_channel));
  std::int8_t* weights = static_cast<std::int8_t*>(memory);
  std::int32_t* bias = reinterpret_cast<std::int32_t*>(weights + sizes.weights);
  float* scale = reinterpret_cast<float*>(weights + sizes.weights + sizes.per_channel);
  const std::int64_t taps = sizes.taps;
  const std::int64_t groups = sizes.inputs / packing.group_inputs;
  const std::int64_t block = std::int64_t{packing.tile_outputs} * packing.group_inputs;
  for (std::int64_t o = 0; o < std::int64_t{layer.copies} * layer.out_channels; ++o) {
    const std::int64_t source = o % layer.out_channels;
    const std::int64_t first = o / layer.out_channels * (layer.in_channels / layer.copies);
    const std::int64_t tile = o / packing.tile_outputs;
    const std::int64_t in_tile = o % packing.tile_outputs;
    for (std::int64_t tap = 0; tap < taps; ++tap) {
      for (std::int64_t i = 0; i < layer.source_channels; ++i) {
        const std::int64_t group = (first + i) / packing.group_inputs;
        const std::int64_t in_group = (first + i) % packing.group_inputs;
        weights[((tile * taps + tap) * groups + group) * block + in_tile * packing.group_inputs + in_group] =
            layer.weights[(source * taps + tap) * layer.source_channels + i];
      }
    }
    bias[o] = layer.bias[source];
    scale[o] = layer.scale[source];
  }
  return {weights, bias, scale};
}

}  // namespace egofocus
