// The networks' convolutions at 346x260 and others, each with its memory: what the benchmarks run.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/conv_u8s8.hpp"

namespace egofocus::bench {

struct ConvLayer {
  const char* name;
  std::int32_t in_channels;
  std::int32_t out_channels;
  std::int32_t side;
  std::int32_t stride;
  std::int32_t dilation;
  std::int32_t rows;
  std::int32_t columns;
  ConvEpilogue epilogue;
  std::int32_t times;             ///< in one tick of the model whose layer it is
  std::int32_t output_pixel = 0;  ///< bytes, where the output is a part of another tensor's channels
  bool zeros_beyond = true;       ///< the border's byte is zero
  std::int32_t depth = 1;         ///< planes of the window
  std::int32_t planes = 1;        ///< of the output
};

/// Those of `base`.
inline constexpr ConvLayer kConvLayers[] = {
    {"focus_3x3_8_8", 8, 8, 3, 1, 1, 65, 87, ConvEpilogue::kRelu, 32, 0, false},
    {"focus_3x3_8_4", 8, 4, 3, 1, 1, 65, 87, ConvEpilogue::kRelu, 32, 144},
    {"mix_1x1_144_48", 144, 48, 1, 1, 1, 65, 87, ConvEpilogue::kRelu, 1},
    {"block4_3x3_48_48", 48, 48, 3, 1, 1, 65, 87, ConvEpilogue::kRelu, 2},
    {"block4_add_3x3_48_48", 48, 48, 3, 1, 1, 65, 87, ConvEpilogue::kAdd, 2},
    {"down_3x3s2_48_80", 48, 80, 3, 2, 1, 33, 44, ConvEpilogue::kRelu, 1},
    {"block8_3x3_80_80", 80, 80, 3, 1, 1, 33, 44, ConvEpilogue::kRelu, 2},
    {"block8_add_3x3_80_80", 80, 80, 3, 1, 1, 33, 44, ConvEpilogue::kAdd, 2},
    {"down_3x3s2_80_128", 80, 128, 3, 2, 1, 17, 22, ConvEpilogue::kRelu, 1},
    {"block16_3x3_128_128", 128, 128, 3, 1, 1, 17, 22, ConvEpilogue::kRelu, 3},
    {"block16_add_3x3_128_128", 128, 128, 3, 1, 1, 17, 22, ConvEpilogue::kAdd, 3},
    {"up_1x1_128_80", 128, 80, 1, 1, 1, 17, 22, ConvEpilogue::kSmall, 1},
    {"up_1x1_80_48", 80, 48, 1, 1, 1, 33, 44, ConvEpilogue::kSmall, 1},
    {"score_1x1_48_32", 48, 32, 1, 1, 1, 65, 87, ConvEpilogue::kScore, 1},
    {"score_1x1_4_1", 4, 1, 1, 1, 1, 5655, 32, ConvEpilogue::kScore, 1},
    {"guide_1x1_48_4", 48, 4, 1, 1, 1, 65, 87, ConvEpilogue::kRelu, 1},
    {"refine_3x3_8_16", 8, 16, 3, 1, 1, 130, 173, ConvEpilogue::kRelu, 1},
    {"refine_3x3_16_16", 16, 16, 3, 1, 1, 130, 173, ConvEpilogue::kRelu, 1},
    {"refine_3x3d2_16_16", 16, 16, 3, 1, 2, 130, 173, ConvEpilogue::kRelu, 1},
    {"refine_3x3d4_16_16", 16, 16, 3, 1, 4, 130, 173, ConvEpilogue::kRelu, 1},
    {"refine_3x3_16_1", 16, 1, 3, 1, 1, 130, 173, ConvEpilogue::kScore, 1},
};

/// Those of `small`, whose hypotheses share convolutions in pairs.
inline constexpr ConvLayer kSmallConvLayers[] = {
    {"focus_3x3_4_4", 4, 4, 3, 1, 1, 65, 87, ConvEpilogue::kRelu, 32, 8, false},
    {"focus_pair_3x3_8_4", 8, 4, 3, 1, 1, 65, 87, ConvEpilogue::kRelu, 16, 80},
    {"mix_1x1_80_24", 80, 24, 1, 1, 1, 65, 87, ConvEpilogue::kRelu, 1},
    {"block4_3x3_24_24", 24, 24, 3, 1, 1, 65, 87, ConvEpilogue::kRelu, 1},
    {"block4_add_3x3_24_24", 24, 24, 3, 1, 1, 65, 87, ConvEpilogue::kAdd, 1},
    {"down_3x3s2_24_40", 24, 40, 3, 2, 1, 33, 44, ConvEpilogue::kRelu, 1},
    {"block8_3x3_40_40", 40, 40, 3, 1, 1, 33, 44, ConvEpilogue::kRelu, 2},
    {"block8_add_3x3_40_40", 40, 40, 3, 1, 1, 33, 44, ConvEpilogue::kAdd, 2},
    {"down_3x3s2_40_64", 40, 64, 3, 2, 1, 17, 22, ConvEpilogue::kRelu, 1},
    {"block16_3x3_64_64", 64, 64, 3, 1, 1, 17, 22, ConvEpilogue::kRelu, 2},
    {"block16_add_3x3_64_64", 64, 64, 3, 1, 1, 17, 22, ConvEpilogue::kAdd, 2},
    {"up_1x1_64_40", 64, 40, 1, 1, 1, 17, 22, ConvEpilogue::kSmall, 1},
    {"up_1x1_40_24", 40, 24, 1, 1, 1, 33, 44, ConvEpilogue::kSmall, 1},
    {"score_1x1_24_32", 24, 32, 1, 1, 1, 65, 87, ConvEpilogue::kScore, 1},
    {"score_pair_1x1_4_2", 4, 2, 1, 1, 1, 5655, 16, ConvEpilogue::kScore, 1},
    {"guide_1x1_24_4", 24, 4, 1, 1, 1, 65, 87, ConvEpilogue::kRelu, 1},
    {"refine_3x3_8_8", 8, 8, 3, 1, 1, 130, 173, ConvEpilogue::kRelu, 2},
    {"refine_3x3d2_8_8", 8, 8, 3, 1, 2, 130, 173, ConvEpilogue::kRelu, 1},
    {"refine_3x3_8_1", 8, 1, 3, 1, 1, 130, 173, ConvEpilogue::kScore, 1},
};

/// The shapes at which inference engines were counted on ARM (docs/kernels-conv.md).
inline constexpr ConvLayer kComparedConvLayers[] = {
    {"3x3_32_32", 32, 32, 3, 1, 1, 66, 88, ConvEpilogue::kRelu, 0},
    {"3x3_64_64", 64, 64, 3, 1, 1, 33, 44, ConvEpilogue::kRelu, 0},
    {"1x1_64_64", 64, 64, 1, 1, 1, 33, 44, ConvEpilogue::kRelu, 0},
    {"3x3s2_32_64", 32, 64, 3, 2, 1, 33, 44, ConvEpilogue::kRelu, 0},
    {"3x3x3_8_8", 8, 8, 3, 1, 1, 33, 44, ConvEpilogue::kRelu, 0, 0, true, 3, 32},
};

/// Over planes (hypotheses), rows and columns, and along the planes alone; in no tick of `base`.
inline constexpr ConvLayer kPlaneLayers[] = {
    {"3x3x3_8_8", 8, 8, 3, 1, 1, 33, 44, ConvEpilogue::kRelu, 1, 0, true, 3, 32},
    {"3x3x3_8_8_fine", 8, 8, 3, 1, 1, 65, 87, ConvEpilogue::kRelu, 1, 0, true, 3, 32},
    {"3x3x3_8_4", 8, 4, 3, 1, 1, 33, 44, ConvEpilogue::kRelu, 1, 0, true, 3, 32},
    {"3x3x3_16_16", 16, 16, 3, 1, 1, 33, 44, ConvEpilogue::kRelu, 1, 0, true, 3, 32},
    {"3x3x3_add_16_16", 16, 16, 3, 1, 1, 33, 44, ConvEpilogue::kAdd, 1, 0, true, 3, 32},
    {"3x1x1_8_8", 8, 8, 1, 1, 1, 33, 44, ConvEpilogue::kRelu, 1, 0, true, 3, 32},
    {"3x1x1_16_16", 16, 16, 1, 1, 1, 33, 44, ConvEpilogue::kRelu, 1, 0, true, 3, 32},
};

/// One layer with random operands and a border of zeros, packed for one variant.
class ConvLoad {
 public:
  ConvLoad(const ConvLayer& layer, const ConvPacking& packing);
  /// Of the first plane.
  const ConvU8S8& conv() const { return conv_; }
  /// All planes.
  void run(ConvU8S8Function* function) const;
  const ConvWeights& given() const { return given_; }
  /// Of the input's interior, without the border: planes, rows, columns and channels without a gap.
  std::vector<std::uint8_t> dense_input() const;
  std::int32_t planes() const { return planes_; }
  std::int32_t input_columns() const { return (conv_.columns - 1) * conv_.stride + 1; }
  std::int32_t input_rows() const { return (conv_.rows - 1) * conv_.stride + 1; }
  double multiplications() const;
  /// What a run left: [planes][rows][columns][out_channels].
  std::vector<std::int32_t> outputs() const;

 private:
  ConvU8S8 conv_;
  ConvWeights given_;
  std::int32_t planes_;
  std::vector<std::uint8_t> input_, addend_, output_;
  std::vector<std::int8_t> weights_;
  std::vector<std::int32_t> bias_;
  std::vector<float> scale_;
  std::vector<std::int64_t> packed_;
};

}  // namespace egofocus::bench
