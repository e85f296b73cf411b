// One call of conv_u8s8 with its memory: input, addend and output end at an unmapped page, all bytes of the
// output (those between pixels and rows too) start as noise, so that a byte changed anywhere shows.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "kernels/conv_u8s8.hpp"
#include "support/guarded_array.hpp"

namespace egofocus::test {

enum class ConvFill { kRandom, kAllMin, kAllMax, kAlternating };
inline constexpr ConvFill kEveryConvFill[] = {ConvFill::kRandom, ConvFill::kAllMin, ConvFill::kAllMax,
                                              ConvFill::kAlternating};

/// For packed weights.
struct AlignedMemory {
  explicit AlignedMemory(std::int64_t bytes)
      : data(std::aligned_alloc(kConvPackedAlignment, static_cast<std::size_t>(bytes))) {}
  ~AlignedMemory() { std::free(data); }
  AlignedMemory(const AlignedMemory&) = delete;
  AlignedMemory& operator=(const AlignedMemory&) = delete;
  void* data;
};

struct ConvCaseShape {
  std::int32_t in_channels;
  std::int32_t out_channels;
  std::int32_t side = 3;
  std::int32_t stride = 1;
  std::int32_t dilation = 1;
  std::int32_t columns = 7;
  std::int32_t rows = 2;
  ConvEpilogue epilogue = ConvEpilogue::kRelu;
  std::int32_t first_row = 0;
  std::int32_t missing_channels = 0;  ///< in_channels - source_channels
  std::int32_t input_gap = 0;         ///< bytes between the channels of neighbouring pixels
  std::int32_t output_gap = 0;        ///< elements, likewise; of the addend too
  std::int32_t row_gap = 0;           ///< elements between rows
  bool in_place = false;              ///< the output is the addend
  bool zeros_beyond = false;          ///< above and below the input, and the call says so
  std::int32_t depth = 1;
  std::int32_t plane_gap = 0;  ///< bytes between input planes
};

std::string describe(const ConvCaseShape& shape);

class ConvCase {
 public:
  ConvCase(const ConvCaseShape& shape, ConvFill fill, std::uint32_t seed);

  /// All bytes of the output after a run on a fresh copy of the start values.
  std::vector<std::uint8_t> run(ConvU8S8Function* function, const ConvPacking& packing);
  /// The same by other means: inputs scattered into sums of 64 bits, the exact product in binary64.
  std::vector<std::uint8_t> expect();

 private:
  void fill_layer(ConvFill fill, std::mt19937& random);
  void fill_input(ConvFill fill, std::mt19937& random);
  std::vector<std::int64_t> sums();
  void leave(std::int64_t sum, std::int32_t o, std::int64_t element, std::vector<std::uint8_t>& bytes);
  std::int64_t output_at(std::int64_t row, std::int64_t column) const;

  ConvCaseShape shape_;
  std::int32_t border_;         // px on each side
  std::int32_t input_columns_;  // with borders
  std::int32_t input_rows_;     // with borders
  std::int32_t input_pixel_;    // bytes
  std::int32_t input_row_;      // bytes
  std::int32_t input_plane_;    // bytes
  std::int32_t element_bytes_;  // of the output
  std::int32_t output_pixel_;   // elements
  std::int32_t output_row_;     // elements
  GuardedArray<std::uint8_t> input_;
  GuardedArray<std::uint8_t> output_;
  GuardedArray<std::uint8_t> addend_;
  std::vector<std::uint8_t> start_;
  std::vector<std::int8_t> weights_;
  std::vector<std::int32_t> bias_;
  std::vector<float> scale_;
};

}  // namespace egofocus::test
