#include "depthwise_case.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace egofocus::test {
namespace {

/// Memory from the first to the last byte that a strided image uses.
std::size_t extent(std::int64_t rows, std::int64_t row, std::int64_t columns, std::int64_t pixel,
                   std::int64_t channels) {
  if (rows <= 0 || columns <= 0) return 0;
  return static_cast<std::size_t>((rows - 1) * row + (columns - 1) * pixel + channels);
}

/// 0..1
double unit(std::mt19937& random) {
  return static_cast<double>(random()) / 4294967296.0;
}

}  // namespace

std::string describe(const DepthwiseCaseShape& s) {
  std::ostringstream text;
  text << s.channels << " channels, stride " << s.stride << " dilation " << s.dilation << ", columns "
       << s.columns << ", rows " << s.first_row << " + " << s.rows << ", epilogue "
       << static_cast<int>(s.epilogue) << ", gaps " << s.input_gap << " " << s.output_gap << " " << s.row_gap
       << (s.in_place ? ", in place" : "");
  return text.str();
}

DepthwiseCase::DepthwiseCase(const DepthwiseCaseShape& s, ConvFill fill, std::uint32_t seed)
    : shape_(s),
      input_columns_((s.columns - 1) * s.stride + 1 + 2 * s.dilation),
      input_rows_((s.first_row + s.rows - 1) * s.stride + 1 + 2 * s.dilation),
      input_pixel_(s.channels + s.input_gap),
      input_row_(input_columns_ * input_pixel_ + s.row_gap),
      output_pixel_(s.channels + s.output_gap),
      output_row_(s.columns * output_pixel_ + s.row_gap),
      input_(extent(input_rows_, input_row_, input_columns_, input_pixel_, s.channels)),
      output_(extent(s.first_row + s.rows, output_row_, s.columns, output_pixel_, s.channels)),
      addend_(output_.size()),
      start_(output_.size()) {
  std::mt19937 random(seed);
  fill_layer(fill, random);
  fill_input(fill, random);
  for (std::uint8_t& byte : start_) byte = static_cast<std::uint8_t>(random() & 127);
  for (std::uint8_t& byte : addend_) byte = static_cast<std::uint8_t>(random() & 127);
}

void DepthwiseCase::fill_layer(ConvFill fill, std::mt19937& random) {
  const std::size_t channels = static_cast<std::size_t>(shape_.channels);
  weights_.resize(9 * channels);
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const std::int32_t sign =
        fill == ConvFill::kAllMin || (fill == ConvFill::kAlternating && i % 2 != 0) ? -1 : 1;
    weights_[i] = static_cast<std::int8_t>(
        fill == ConvFill::kRandom ? static_cast<std::int32_t>(random() % 255) - 127 : 127 * sign);
  }
  for (std::size_t c = 0; c < channels; ++c) {
    constexpr double kSpread = 4000.0 * 3;
    bias_.push_back(static_cast<std::int32_t>((unit(random) - 0.5) * kSpread));
    scale_.push_back(static_cast<float>((0.3 + unit(random) * 6.0) * 60.0 / kSpread));
    if (c % 5 == 3) scale_[c] = 1.0f / 256.0f;  // exact halves
    if (c % 7 == 4) scale_[c] = 0.999999f;      // saturates all ranges
    if (c % 11 == 6) scale_[c] = 9.2e-13f;      // always 0
    if (fill == ConvFill::kAllMax && c % 3 == 0) bias_[c] = 1 << 30;
    if (fill == ConvFill::kAllMin && c % 3 == 0) bias_[c] = -(1 << 30);
  }
}

void DepthwiseCase::fill_input(ConvFill fill, std::mt19937& random) {
  for (std::uint8_t& byte : input_) byte = static_cast<std::uint8_t>(random());  // in gaps: any byte
  for (std::int32_t pixel = 0; pixel < std::max(input_rows_ * input_columns_, 0); ++pixel) {
    const std::int32_t x = pixel % input_columns_;
    std::uint8_t* at =
        input_.data() + std::int64_t{pixel / input_columns_} * input_row_ + std::int64_t{x} * input_pixel_;
    if (shape_.columns == 0 || shape_.first_row + shape_.rows == 0) return;
    for (std::int32_t c = 0; c < shape_.channels; ++c) {
      at[c] = fill == ConvFill::kAlternating && (c + x) % 2 != 0 ? 0 : 127;
      if (fill == ConvFill::kRandom) at[c] = static_cast<std::uint8_t>(random() & 127);
    }
  }
}

std::vector<std::uint8_t> DepthwiseCase::run(DepthwiseU8S8Function* function,
                                             const DepthwisePacking& packing) {
  const DepthwiseWeights layer{weights_.data(), bias_.data(), scale_.data(), shape_.channels};
  const AlignedMemory memory(depthwise_packed_bytes(packing, shape_.channels));
  std::copy(start_.begin(), start_.end(), output_.begin());
  DepthwiseU8S8 conv;
  conv.input = input_.data() + std::int64_t{shape_.dilation} * (input_row_ + input_pixel_);
  conv.input_row_stride = input_row_;
  conv.input_pixel_stride = input_pixel_;
  if (shape_.epilogue == ConvEpilogue::kAdd) {
    conv.addend = shape_.in_place ? output_.data() : addend_.data();
    conv.addend_row_stride = output_row_;
    conv.addend_pixel_stride = output_pixel_;
  }
  conv.output = output_.data();
  conv.output_row_stride = output_row_;
  conv.output_pixel_stride = output_pixel_;
  conv.packed = pack_depthwise_u8s8(packing, layer, memory.data);
  conv.channels = shape_.channels;
  conv.stride = shape_.stride;
  conv.dilation = shape_.dilation;
  conv.epilogue = shape_.epilogue;
  conv.columns = shape_.columns;
  conv.first_row = shape_.first_row;
  conv.rows = shape_.rows;
  function(conv);
  return {output_.begin(), output_.end()};
}

std::uint8_t DepthwiseCase::leave(std::int64_t sum, std::int32_t c, std::uint8_t addend) const {
  const std::size_t channel = static_cast<std::size_t>(c);
  // The product of two binary32 numbers is exact in binary64; its one rounding to binary32 is the rule's.
  const double near = static_cast<float>(sum + bias_[channel]);
  const double product = static_cast<float>(near * static_cast<double>(scale_[channel]));
  const double r = std::nearbyint(product);
  if (shape_.epilogue == ConvEpilogue::kSmall)
    return static_cast<std::uint8_t>(static_cast<int>(std::max(-128.0, std::min(127.0, r))));
  const double added = shape_.epilogue == ConvEpilogue::kAdd ? addend + r : r;
  return static_cast<std::uint8_t>(std::max(0.0, std::min(127.0, added)));
}

std::vector<std::uint8_t> DepthwiseCase::expect() {
  const std::int32_t rows = shape_.first_row + shape_.rows;
  std::vector<std::int64_t> sums(static_cast<std::size_t>(rows * shape_.columns * shape_.channels));
  for (std::int32_t y = 0; y < input_rows_; ++y) {
    for (std::int32_t x = 0; x < input_columns_; ++x) {
      for (std::int32_t tap = 0; tap < 9; ++tap) {
        const std::int32_t from_row = y - tap / 3 * shape_.dilation;
        const std::int32_t from_column = x - tap % 3 * shape_.dilation;
        if (from_row < 0 || from_row % shape_.stride != 0 || from_row / shape_.stride >= rows) continue;
        if (from_column < 0 || from_column % shape_.stride != 0) continue;
        if (from_column / shape_.stride >= shape_.columns) continue;
        const std::int32_t pixel = from_row / shape_.stride * shape_.columns + from_column / shape_.stride;
        const std::uint8_t* in =
            input_.data() + std::int64_t{y} * input_row_ + std::int64_t{x} * input_pixel_;
        for (std::int32_t c = 0; c < shape_.channels; ++c)
          sums[static_cast<std::size_t>(pixel * shape_.channels + c)] +=
              std::int64_t{weights_[static_cast<std::size_t>(9 * c + tap)]} * in[c];
      }
    }
  }
  std::vector<std::uint8_t> bytes = start_;
  for (std::int32_t row = shape_.first_row; row < rows; ++row) {
    for (std::int32_t i = 0; i < shape_.columns * shape_.channels; ++i) {
      const std::int32_t c = i % shape_.channels;
      const std::size_t at =
          static_cast<std::size_t>(row * output_row_ + i / shape_.channels * output_pixel_ + c);
      bytes[at] = leave(sums[static_cast<std::size_t>(row * shape_.columns * shape_.channels + i)], c,
                        shape_.in_place ? start_[at] : addend_[at]);
    }
  }
  return bytes;
}

}  // namespace egofocus::test
