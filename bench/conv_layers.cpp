#include "conv_layers.hpp"

#include <random>

namespace egofocus::bench {

ConvLoad::ConvLoad(const ConvLayer& layer, const ConvPacking& packing) {
  std::mt19937 random(5);
  const auto below = [&random](std::uint32_t end) { return static_cast<std::int32_t>(random() % end); };
  const std::int32_t border = layer.side / 2 * layer.dilation;
  const std::int32_t columns = (layer.columns - 1) * layer.stride + 1 + 2 * border;
  const std::int32_t rows = (layer.rows - 1) * layer.stride + 1 + 2 * border;
  const std::int32_t element = layer.epilogue == ConvEpilogue::kScore ? 2 : 1;
  const std::int32_t pixel = layer.output_pixel != 0 ? layer.output_pixel : layer.out_channels * element;
  const std::size_t terms = static_cast<std::size_t>(layer.side * layer.side * layer.in_channels);
  const std::size_t outputs = static_cast<std::size_t>(layer.out_channels);

  std::vector<std::int8_t> weights(outputs * terms);
  for (std::int8_t& weight : weights) weight = static_cast<std::int8_t>(below(255) - 127);
  const std::vector<std::int32_t> bias(outputs, 1000);
  const std::vector<float> scale(outputs, 1e-4f);
  ConvWeights given;
  given.weights = weights.data();
  given.bias = bias.data();
  given.scale = scale.data();
  given.source_channels = given.in_channels = layer.in_channels;
  given.out_channels = layer.out_channels;
  given.side = layer.side;
  packed_.resize(static_cast<std::size_t>((conv_packed_bytes(packing, given) + kConvPackedAlignment) / 8));
  const std::uintptr_t at = reinterpret_cast<std::uintptr_t>(packed_.data());
  const std::uintptr_t aligned =
      (at + kConvPackedAlignment - 1) / kConvPackedAlignment * kConvPackedAlignment;
  conv_.packed = pack_conv_u8s8(packing, given, reinterpret_cast<void*>(aligned));

  input_.resize(static_cast<std::size_t>(rows * columns * layer.in_channels));
  for (std::uint8_t& byte : input_) byte = static_cast<std::uint8_t>(below(128));
  output_.resize(static_cast<std::size_t>(layer.rows * layer.columns * pixel));
  addend_ = output_;
  conv_.input_pixel_stride = layer.in_channels;
  conv_.input_row_stride = columns * layer.in_channels;
  conv_.input = input_.data() + border * (conv_.input_row_stride + conv_.input_pixel_stride);
  conv_.addend = addend_.data();
  conv_.addend_pixel_stride = conv_.output_pixel_stride = pixel;
  conv_.addend_row_stride = conv_.output_row_stride = layer.columns * pixel;
  conv_.output = output_.data();
  conv_.in_channels = layer.in_channels;
  conv_.out_channels = layer.out_channels;
  conv_.side = layer.side;
  conv_.stride = layer.stride;
  conv_.dilation = layer.dilation;
  conv_.epilogue = layer.epilogue;
  conv_.columns = layer.columns;
  conv_.rows = layer.rows;
}

double ConvLoad::multiplications() const {
  return static_cast<double>(conv_.side * conv_.side * conv_.in_channels) * conv_.out_channels * conv_.rows *
         conv_.columns;
}

}  // namespace egofocus::bench
