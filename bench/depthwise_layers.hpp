// Depthwise convolutions, each with its memory: what the benchmarks run. None is in a tick of `base`.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/depthwise_u8s8.hpp"

namespace egofocus::bench {

struct DepthwiseLayer {
  const char* name;
  std::int32_t channels;
  std::int32_t stride;
  std::int32_t dilation;
  std::int32_t rows;
  std::int32_t columns;
  ConvEpilogue epilogue;
};

/// The first is the shape at which inference engines were counted on ARM (docs/kernels-conv.md). Gradients
/// leave as s8.
inline constexpr DepthwiseLayer kDepthwiseLayers[] = {
    {"depthwise_48", 48, 1, 1, 132, 176, ConvEpilogue::kRelu},
    {"depthwise_add_48", 48, 1, 1, 132, 176, ConvEpilogue::kAdd},
    {"depthwise_s2_48", 48, 2, 1, 66, 88, ConvEpilogue::kRelu},
    {"depthwise_80", 80, 1, 1, 33, 44, ConvEpilogue::kRelu},
    {"depthwise_128", 128, 1, 1, 17, 22, ConvEpilogue::kRelu},
    {"depthwise_d2_16", 16, 1, 2, 130, 173, ConvEpilogue::kRelu},
    {"gradient_8", 8, 1, 1, 130, 173, ConvEpilogue::kSmall},
    {"gradient_32", 32, 1, 1, 65, 87, ConvEpilogue::kSmall},
};

/// One layer with random operands and a border of zeros, packed for one variant.
class DepthwiseLoad {
 public:
  DepthwiseLoad(const DepthwiseLayer& layer, const DepthwisePacking& packing);
  void run(DepthwiseU8S8Function* function) const { function(conv_); }
  const DepthwiseU8S8& conv() const { return conv_; }
  const DepthwiseWeights& given() const { return given_; }
  /// Of the input's interior, without the border: rows, columns and channels without a gap.
  std::vector<std::uint8_t> dense_input() const;
  std::int32_t input_columns() const { return (conv_.columns - 1) * conv_.stride + 1; }
  std::int32_t input_rows() const { return (conv_.rows - 1) * conv_.stride + 1; }
  double multiplications() const { return 9.0 * conv_.channels * conv_.rows * conv_.columns; }
  /// What a run left: [rows][columns][channels].
  std::vector<std::int32_t> outputs() const;

 private:
  DepthwiseU8S8 conv_;
  DepthwiseWeights given_;
  std::vector<std::uint8_t> input_, addend_, output_;
  std::vector<std::int8_t> weights_;
  std::vector<std::int32_t> bias_;
  std::vector<float> scale_;
  std::vector<std::int64_t> packed_;
};

}  // namespace egofocus::bench
