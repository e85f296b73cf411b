#include "conv_layers.hpp"

#include <random>

namespace egofocus::bench {

ConvLoad::ConvLoad(const ConvLayer& layer, const ConvPacking& packing) : planes_(layer.planes) {
  std::mt19937 random(5);
  const auto below = [&random](std::uint32_t end) { return static_cast<std::int32_t>(random() % end); };
  conv_.in_channels = layer.in_channels;
  conv_.out_channels = layer.out_channels;
  conv_.side = layer.side;
  conv_.depth = layer.depth;
  conv_.stride = layer.stride;
  conv_.dilation = layer.dilation;
  conv_.epilogue = layer.epilogue;
  conv_.columns = layer.columns;
  conv_.rows = layer.rows;

  const std::size_t outputs = static_cast<std::size_t>(layer.out_channels);
  weights_.resize(outputs *
                  static_cast<std::size_t>(layer.depth * layer.side * layer.side * layer.in_channels));
  for (std::int8_t& weight : weights_) weight = static_cast<std::int8_t>(below(255) - 127);
  for (std::size_t o = 0; o < outputs; ++o) {
    bias_.push_back(below(20000));
    scale_.push_back(1e-6f * static_cast<float>(50 + below(100)));
  }
  given_.weights = weights_.data();
  given_.bias = bias_.data();
  given_.scale = scale_.data();
  given_.source_channels = given_.in_channels = layer.in_channels;
  given_.out_channels = layer.out_channels;
  given_.side = layer.side;
  given_.depth = layer.depth;
  packed_.resize(static_cast<std::size_t>((conv_packed_bytes(packing, given_) + kConvPackedAlignment) / 8));
  const std::uintptr_t at = reinterpret_cast<std::uintptr_t>(packed_.data());
  const std::uintptr_t aligned =
      (at + kConvPackedAlignment - 1) / kConvPackedAlignment * kConvPackedAlignment;
  conv_.packed = pack_conv_u8s8(packing, given_, reinterpret_cast<void*>(aligned));

  const std::int32_t border = layer.side / 2 * layer.dilation;
  conv_.input_pixel_stride = layer.in_channels;
  conv_.input_row_stride = (input_columns() + 2 * border) * layer.in_channels;
  conv_.input_plane_stride = (input_rows() + 2 * border) * conv_.input_row_stride;
  input_.resize(static_cast<std::size_t>((layer.planes + layer.depth - 1) * conv_.input_plane_stride));
  std::uint8_t* inside = input_.data() + layer.depth / 2 * conv_.input_plane_stride +
                         border * (conv_.input_row_stride + conv_.input_pixel_stride);
  for (std::int32_t row = 0; row < layer.planes * input_rows(); ++row) {
    std::uint8_t* const begin =
        inside + row / input_rows() * conv_.input_plane_stride + row % input_rows() * conv_.input_row_stride;
    for (std::int32_t b = 0; b < input_columns() * layer.in_channels; ++b)
      begin[b] = static_cast<std::uint8_t>(below(128));
  }
  conv_.input = inside;
  conv_.zeros_beyond = layer.zeros_beyond;
  conv_.input_rows = input_rows();

  const std::int32_t element = layer.epilogue == ConvEpilogue::kScore ? 2 : 1;
  const std::int32_t pixel = layer.output_pixel != 0 ? layer.output_pixel : layer.out_channels * element;
  output_.resize(static_cast<std::size_t>(layer.planes * layer.rows * layer.columns * pixel));
  addend_.resize(output_.size());
  for (std::uint8_t& byte : addend_) byte = static_cast<std::uint8_t>(below(128));
  conv_.addend = addend_.data();
  conv_.addend_pixel_stride = conv_.output_pixel_stride = pixel;
  conv_.addend_row_stride = conv_.output_row_stride = layer.columns * pixel;
  conv_.output = output_.data();
}

void ConvLoad::run(ConvU8S8Function* function) const {
  const std::int64_t plane_bytes = std::int64_t{conv_.rows} * conv_.output_row_stride;
  ConvU8S8 conv = conv_;
  for (std::int32_t plane = 0; plane < planes_; ++plane) {
    function(conv);
    conv.input += conv.input_plane_stride;
    conv.addend += plane_bytes;
    conv.output = static_cast<std::uint8_t*>(conv.output) + plane_bytes;
  }
}

std::vector<std::uint8_t> ConvLoad::dense_input() const {
  std::vector<std::uint8_t> dense;
  for (std::int32_t row = 0; row < planes_ * input_rows(); ++row) {
    const std::uint8_t* const at = conv_.input + row / input_rows() * conv_.input_plane_stride +
                                   row % input_rows() * conv_.input_row_stride;
    dense.insert(dense.end(), at, at + input_columns() * conv_.in_channels);
  }
  return dense;
}

double ConvLoad::multiplications() const {
  return static_cast<double>(conv_.depth * conv_.side * conv_.side * conv_.in_channels) * conv_.out_channels *
         conv_.rows * conv_.columns * planes_;
}

std::vector<std::int32_t> ConvLoad::outputs() const {
  std::vector<std::int32_t> values;
  for (std::int32_t pixel = 0; pixel < planes_ * conv_.rows * conv_.columns; ++pixel) {
    const std::uint8_t* at = output_.data() + static_cast<std::ptrdiff_t>(pixel) * conv_.output_pixel_stride;
    for (std::int32_t o = 0; o < conv_.out_channels; ++o) {
      if (conv_.epilogue == ConvEpilogue::kScore) {
        values.push_back(reinterpret_cast<const std::int16_t*>(at)[o]);
      } else {
        values.push_back(conv_.epilogue == ConvEpilogue::kSmall ? static_cast<std::int8_t>(at[o]) : at[o]);
      }
    }
  }
  return values;
}

}  // namespace egofocus::bench
