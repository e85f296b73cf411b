#include "conv_case.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

namespace egofocus::test {
namespace {

/// Memory from the first to the last element that a strided image uses.
std::size_t extent(std::int64_t rows, std::int64_t row, std::int64_t columns, std::int64_t pixel,
                   std::int64_t channels) {
  if (rows <= 0 || columns <= 0) return 0;
  return static_cast<std::size_t>((rows - 1) * row + (columns - 1) * pixel + channels);
}

std::size_t volume(std::int64_t planes, std::int64_t plane, std::size_t last) {
  return last == 0 ? 0 : static_cast<std::size_t>((planes - 1) * plane) + last;
}

/// 0..1
double unit(std::mt19937& random) {
  return static_cast<double>(random()) / 4294967296.0;
}

}  // namespace

std::string describe(const ConvCaseShape& s) {
  std::ostringstream text;
  text << s.depth << "x" << s.side << "x" << s.side << " stride " << s.stride << " dilation " << s.dilation
       << " " << s.in_channels << " (-" << s.missing_channels << ") -> " << s.out_channels << ", columns "
       << s.columns << ", rows " << s.first_row << " + " << s.rows << ", epilogue "
       << static_cast<int>(s.epilogue) << ", gaps " << s.input_gap << " " << s.output_gap << " " << s.row_gap
       << " " << s.plane_gap << (s.in_place ? ", in place" : "") << (s.zeros_beyond ? ", zeros beyond" : "");
  return text.str();
}

ConvCase::ConvCase(const ConvCaseShape& s, ConvFill fill, std::uint32_t seed)
    : shape_(s),
      border_(s.side / 2 * s.dilation),
      input_columns_((s.columns - 1) * s.stride + 1 + 2 * border_),
      input_rows_((s.first_row + s.rows - 1) * s.stride + 1 + 2 * border_),
      input_pixel_(s.in_channels + s.input_gap),
      input_row_(input_columns_ * input_pixel_ + s.row_gap),
      input_plane_(input_rows_ * input_row_ + s.plane_gap),
      element_bytes_(s.epilogue == ConvEpilogue::kScore ? 2 : 1),
      output_pixel_(s.out_channels + s.output_gap),
      output_row_(s.columns * output_pixel_ + s.row_gap),
      input_(volume(s.depth, input_plane_,
                    extent(input_rows_, input_row_, input_columns_, input_pixel_, s.in_channels))),
      output_(static_cast<std::size_t>(element_bytes_) *
              extent(s.first_row + s.rows, output_row_, s.columns, output_pixel_, s.out_channels)),
      addend_(output_.size()),
      start_(output_.size()) {
  std::mt19937 random(seed);
  fill_layer(fill, random);
  fill_input(fill, random);
  for (std::uint8_t& byte : start_) byte = static_cast<std::uint8_t>(random() & 127);
  for (std::uint8_t& byte : addend_) byte = static_cast<std::uint8_t>(random() & 127);
}

void ConvCase::fill_layer(ConvFill fill, std::mt19937& random) {
  const std::size_t source = static_cast<std::size_t>(shape_.in_channels - shape_.missing_channels);
  const std::size_t terms = static_cast<std::size_t>(shape_.depth * shape_.side * shape_.side) * source;
  const std::size_t outputs = static_cast<std::size_t>(shape_.out_channels);
  weights_.resize(outputs * terms);
  bias_.resize(outputs);
  scale_.resize(outputs);
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const std::int32_t sign =
        fill == ConvFill::kAllMin || (fill == ConvFill::kAlternating && i % 2 != 0) ? -1 : 1;
    weights_[i] = static_cast<std::int8_t>(
        fill == ConvFill::kRandom ? static_cast<std::int32_t>(random() % 255) - 127 : 127 * sign);
  }
  for (std::size_t o = 0; o < outputs; ++o) {
    const double spread = 4000.0 * std::sqrt(static_cast<double>(terms));
    const double to_byte = (0.3 + unit(random) * 6.0) * 60.0 / spread;
    bias_[o] = static_cast<std::int32_t>((unit(random) - 0.5) * spread);
    scale_[o] = static_cast<float>(to_byte);
    if (o % 5 == 3) scale_[o] = 1.0f / 256.0f;  // exact halves
    if (o % 7 == 4) scale_[o] = 0.999999f;      // saturates all ranges
    if (o % 11 == 6) scale_[o] = 9.2e-13f;      // always 0
    if (fill == ConvFill::kAllMax && o % 3 == 0) bias_[o] = 1 << 30;
    if (fill == ConvFill::kAllMin && o % 3 == 0) bias_[o] = -(1 << 30);
  }
}

void ConvCase::fill_input(ConvFill fill, std::mt19937& random) {
  for (std::uint8_t& byte : input_) byte = static_cast<std::uint8_t>(random());
  for (std::int32_t row = 0; row < shape_.depth * input_rows_; ++row) {
    const std::int32_t y = row % input_rows_;
    for (std::int32_t x = 0; x < input_columns_; ++x) {
      std::uint8_t* pixel = input_.data() + std::int64_t{row / input_rows_} * input_plane_ +
                            std::int64_t{y} * input_row_ + std::int64_t{x} * input_pixel_;
      for (std::int32_t i = 0; i < shape_.in_channels; ++i) {
        if (fill == ConvFill::kRandom || i >= shape_.in_channels - shape_.missing_channels) {
          pixel[i] = static_cast<std::uint8_t>(random() & 127);
        } else {
          pixel[i] = fill == ConvFill::kAlternating && (i + x) % 2 != 0 ? 0 : 127;
        }
        const bool beyond = y < border_ || y >= input_rows_ - border_;
        if (shape_.zeros_beyond && beyond) pixel[i] = 0;
      }
    }
  }
}

std::int64_t ConvCase::output_at(std::int64_t row, std::int64_t column) const {
  return row * output_row_ + column * output_pixel_;
}

std::vector<std::uint8_t> ConvCase::run(ConvU8S8Function* function, const ConvPacking& packing) {
  ConvWeights layer;
  layer.weights = weights_.data();
  layer.bias = bias_.data();
  layer.scale = scale_.data();
  layer.source_channels = shape_.in_channels - shape_.missing_channels;
  layer.in_channels = shape_.in_channels;
  layer.out_channels = shape_.out_channels;
  layer.side = shape_.side;
  layer.depth = shape_.depth;
  const AlignedMemory memory(conv_packed_bytes(packing, layer));

  std::copy(start_.begin(), start_.end(), output_.begin());
  ConvU8S8 conv;
  conv.input =
      input_.data() + shape_.depth / 2 * input_plane_ + std::int64_t{border_} * (input_row_ + input_pixel_);
  conv.input_row_stride = input_row_;
  conv.input_pixel_stride = input_pixel_;
  conv.input_plane_stride = input_plane_;
  conv.zeros_beyond = shape_.zeros_beyond;
  conv.input_rows = input_rows_ - 2 * border_;
  if (shape_.epilogue == ConvEpilogue::kAdd) {
    conv.addend = shape_.in_place ? output_.data() : addend_.data();
    conv.addend_row_stride = output_row_;
    conv.addend_pixel_stride = output_pixel_;
  }
  conv.output = output_.data();
  conv.output_row_stride = output_row_ * element_bytes_;
  conv.output_pixel_stride = output_pixel_ * element_bytes_;
  conv.packed = pack_conv_u8s8(packing, layer, memory.data);
  conv.in_channels = shape_.in_channels;
  conv.out_channels = shape_.out_channels;
  conv.side = shape_.side;
  conv.depth = shape_.depth;
  conv.stride = shape_.stride;
  conv.dilation = shape_.dilation;
  conv.epilogue = shape_.epilogue;
  conv.columns = shape_.columns;
  conv.first_row = shape_.first_row;
  conv.rows = shape_.rows;
  function(conv);
  return {output_.begin(), output_.end()};
}

std::vector<std::int64_t> ConvCase::sums() {
  const std::int32_t source = shape_.in_channels - shape_.missing_channels;
  const std::int32_t outputs = shape_.out_channels;
  std::vector<std::int64_t> sums(static_cast<std::size_t>((shape_.first_row + shape_.rows) * shape_.columns) *
                                 static_cast<std::size_t>(outputs));
  const std::int32_t taps = shape_.side * shape_.side;
  const std::int32_t columns = std::max(input_columns_, 0);  // no output column, and no border
  for (std::int32_t from = 0; from < shape_.depth * input_rows_ * columns; ++from) {
    const std::int32_t z = from / columns / input_rows_;
    const std::int32_t y = from / columns % input_rows_;
    const std::int32_t x = from % columns;
    const std::uint8_t* pixel = input_.data() + std::int64_t{z} * input_plane_ +
                                std::int64_t{y} * input_row_ + std::int64_t{x} * input_pixel_;
    for (std::int32_t tap = 0; tap < taps; ++tap) {
      const std::int32_t from_row = y - tap / shape_.side * shape_.dilation;
      const std::int32_t from_column = x - tap % shape_.side * shape_.dilation;
      if (from_row < 0 || from_column < 0) continue;
      if (from_row % shape_.stride != 0 || from_column % shape_.stride != 0) continue;
      const std::int32_t row = from_row / shape_.stride;
      const std::int32_t column = from_column / shape_.stride;
      if (row >= shape_.first_row + shape_.rows || column >= shape_.columns) continue;
      for (std::int32_t o = 0; o < outputs; ++o) {
        const std::int8_t* weight =
            weights_.data() + ((std::int64_t{o} * shape_.depth + z) * taps + tap) * source;
        std::int64_t& sum = sums[static_cast<std::size_t>((row * shape_.columns + column) * outputs + o)];
        for (std::int32_t i = 0; i < source; ++i) sum += std::int64_t{weight[i]} * pixel[i];
      }
    }
  }
  return sums;
}

void ConvCase::leave(std::int64_t sum, std::int32_t o, std::int64_t element,
                     std::vector<std::uint8_t>& bytes) {
  // The product of two binary32 numbers is exact in binary64; its one rounding to binary32 is the rule's.
  const double near = static_cast<float>(sum + bias_[static_cast<std::size_t>(o)]);
  const double product = static_cast<float>(near * static_cast<double>(scale_[static_cast<std::size_t>(o)]));
  const double r = std::max(-32768.0, std::min(32767.0, std::nearbyint(product)));
  const std::size_t at = static_cast<std::size_t>(element);
  const std::uint8_t x = shape_.in_place ? start_[at] : addend_[at];
  switch (shape_.epilogue) {
    case ConvEpilogue::kRelu:
      bytes[at] = static_cast<std::uint8_t>(std::max(0.0, std::min(127.0, r)));
      break;
    case ConvEpilogue::kAdd:
      bytes[at] = static_cast<std::uint8_t>(std::max(0.0, std::min(127.0, x + r)));
      break;
    case ConvEpilogue::kSmall:
      bytes[at] = static_cast<std::uint8_t>(static_cast<int>(std::max(-128.0, std::min(127.0, r))));
      break;
    case ConvEpilogue::kScore: {
      const std::int16_t score = static_cast<std::int16_t>(r);
      std::memcpy(&bytes[2 * at], &score, sizeof score);
      break;
    }
  }
}

std::vector<std::uint8_t> ConvCase::expect() {
  const std::vector<std::int64_t> all = sums();
  std::vector<std::uint8_t> bytes = start_;
  for (std::int32_t row = shape_.first_row; row < shape_.first_row + shape_.rows; ++row) {
    for (std::int32_t column = 0; column < shape_.columns; ++column) {
      for (std::int32_t o = 0; o < shape_.out_channels; ++o) {
        const std::int32_t sum = (row * shape_.columns + column) * shape_.out_channels + o;
        leave(all[static_cast<std::size_t>(sum)], o, output_at(row, column) + o, bytes);
      }
    }
  }
  return bytes;
}

}  // namespace egofocus::test
