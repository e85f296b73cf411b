// One call of depthwise_u8s8 with its memory: input, addend and output end at an unmapped page, all bytes of
// the output (those between pixels and rows too) start as noise, so that a byte changed anywhere shows.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "conv_case.hpp"
#include "kernels/depthwise_u8s8.hpp"
#include "support/guarded_array.hpp"

namespace egofocus::test {

struct DepthwiseCaseShape {
  std::int32_t channels;
  std::int32_t columns = 7;
  std::int32_t rows = 2;
  ConvEpilogue epilogue = ConvEpilogue::kRelu;
  std::int32_t stride = 1;
  std::int32_t dilation = 1;
  std::int32_t first_row = 0;
  std::int32_t input_gap = 0;   ///< bytes between the channels of neighbouring pixels
  std::int32_t output_gap = 0;  ///< bytes, likewise; of the addend too
  std::int32_t row_gap = 0;     ///< bytes between rows
  bool in_place = false;        ///< the output is the addend
};

std::string describe(const DepthwiseCaseShape& shape);

class DepthwiseCase {
 public:
  DepthwiseCase(const DepthwiseCaseShape& shape, ConvFill fill, std::uint32_t seed);

  /// All bytes of the output after a run on a fresh copy of the start values.
  std::vector<std::uint8_t> run(DepthwiseU8S8Function* function, const DepthwisePacking& packing);
  /// The same by other means: inputs scattered into sums of 64 bits, the exact product in binary64.
  std::vector<std::uint8_t> expect();

 private:
  void fill_layer(ConvFill fill, std::mt19937& random);
  void fill_input(ConvFill fill, std::mt19937& random);
  std::uint8_t leave(std::int64_t sum, std::int32_t c, std::uint8_t addend) const;

  DepthwiseCaseShape shape_;
  std::int32_t input_columns_;  // with borders
  std::int32_t input_rows_;     // with borders
  std::int32_t input_pixel_;    // bytes, as are the following
  std::int32_t input_row_;
  std::int32_t output_pixel_;
  std::int32_t output_row_;
  GuardedArray<std::uint8_t> input_;
  GuardedArray<std::uint8_t> output_;
  GuardedArray<std::uint8_t> addend_;
  std::vector<std::uint8_t> start_;
  std::vector<std::int8_t> weights_;
  std::vector<std::int32_t> bias_;
  std::vector<float> scale_;
};

}  // namespace egofocus::test
