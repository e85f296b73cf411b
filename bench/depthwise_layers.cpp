#include "depthwise_layers.hpp"

#include <random>

namespace egofocus::bench {

DepthwiseLoad::DepthwiseLoad(const DepthwiseLayer& layer, const DepthwisePacking& packing) {
  std::mt19937 random(5);
  const auto below = [&random](std::uint32_t end) { return static_cast<std::int32_t>(random() % end); };
  conv_.channels = layer.channels;
  conv_.stride = layer.stride;
  conv_.dilation = layer.dilation;
  conv_.epilogue = layer.epilogue;
  conv_.columns = layer.columns;
  conv_.rows = layer.rows;

  for (std::int32_t i = 0; i < 9 * layer.channels; ++i)
    weights_.push_back(static_cast<std::int8_t>(below(255) - 127));
  for (std::int32_t c = 0; c < layer.channels; ++c) {
    bias_.push_back(below(20000));
    scale_.push_back(1e-5f * static_cast<float>(50 + below(100)));
  }
  given_ = {weights_.data(), bias_.data(), scale_.data(), layer.channels};
  packed_.resize(
      static_cast<std::size_t>((depthwise_packed_bytes(packing, layer.channels) + kConvPackedAlignment) / 8));
  const std::uintptr_t at = reinterpret_cast<std::uintptr_t>(packed_.data());
  const std::uintptr_t aligned =
      (at + kConvPackedAlignment - 1) / kConvPackedAlignment * kConvPackedAlignment;
  conv_.packed = pack_depthwise_u8s8(packing, given_, reinterpret_cast<void*>(aligned));

  conv_.input_pixel_stride = layer.channels;
  conv_.input_row_stride = (input_columns() + 2 * layer.dilation) * layer.channels;
  input_.resize(static_cast<std::size_t>((input_rows() + 2 * layer.dilation) * conv_.input_row_stride));
  std::uint8_t* const inside =
      input_.data() + layer.dilation * (conv_.input_row_stride + conv_.input_pixel_stride);
  for (std::int32_t y = 0; y < input_rows(); ++y) {
    for (std::int32_t b = 0; b < input_columns() * layer.channels; ++b)
      inside[y * conv_.input_row_stride + b] = static_cast<std::uint8_t>(below(128));
  }
  conv_.input = inside;

  output_.resize(static_cast<std::size_t>(layer.rows * layer.columns * layer.channels));
  addend_.resize(output_.size());
  for (std::uint8_t& byte : addend_) byte = static_cast<std::uint8_t>(below(128));
  conv_.addend = addend_.data();
  conv_.output = output_.data();
  conv_.addend_pixel_stride = conv_.output_pixel_stride = layer.channels;
  conv_.addend_row_stride = conv_.output_row_stride = layer.columns * layer.channels;
}

std::vector<std::uint8_t> DepthwiseLoad::dense_input() const {
  std::vector<std::uint8_t> dense;
  for (std::int32_t y = 0; y < input_rows(); ++y) {
    const std::uint8_t* const row = conv_.input + y * conv_.input_row_stride;
    dense.insert(dense.end(), row, row + input_columns() * conv_.channels);
  }
  return dense;
}

std::vector<std::int32_t> DepthwiseLoad::outputs() const {
  std::vector<std::int32_t> values;
  for (const std::uint8_t byte : output_)
    values.push_back(conv_.epilogue == ConvEpilogue::kSmall ? static_cast<std::int8_t>(byte) : byte);
  return values;
}

}  // namespace egofocus::bench
