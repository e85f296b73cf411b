#include "pipeline/conv_layer.hpp"

#include "core/check.hpp"

namespace egofocus {

static_assert(Arena::kAlignment % kConvPackedAlignment == 0);

ConvLayer::ConvLayer(const ModelLayer& layer, std::int32_t channels, const KernelTable& kernels, Arena& arena,
                     std::int32_t copies) noexcept
    : run_(kernels.conv_u8s8.run) {
  EGOFOCUS_CHECK(channels % 4 == 0 && channels % copies == 0 && channels / copies >= layer.shape.inputs);
  conv_.in_channels = channels;
  conv_.out_channels = copies * layer.shape.outputs;
  conv_.side = layer.shape.side;
  conv_.stride = layer.shape.stride;
  conv_.dilation = layer.shape.dilation;
  conv_.zeros_beyond = layer.shape.zero == 0;
  ConvWeights weights;
  weights.weights = layer.weights;
  weights.bias = layer.bias;
  weights.scale = layer.scale;
  weights.source_channels = layer.shape.inputs;
  weights.in_channels = channels;
  weights.out_channels = layer.shape.outputs;
  weights.side = layer.shape.side;
  weights.copies = copies;
  const ConvPacking& packing = kernels.conv_u8s8.packing;
  const auto bytes = static_cast<std::size_t>(conv_packed_bytes(packing, weights));
  const std::span<std::byte> memory = arena.array<std::byte>(bytes);
  if (!memory.empty()) conv_.packed = pack_conv_u8s8(packing, weights, memory.data());
}

ConvU8S8 ConvLayer::call(const Tensor& input, std::int32_t first, std::int32_t rows) const noexcept {
  EGOFOCUS_CHECK(input.shape.channels >= conv_.in_channels);
  EGOFOCUS_CHECK(input.shape.border >= conv_.side / 2 * conv_.dilation);
  ConvU8S8 conv = conv_;
  conv.input = input.origin;
  conv.input_row_stride = input.shape.row_stride();
  conv.input_pixel_stride = input.shape.channels;
  conv.input_rows = input.shape.height;
  conv.columns = (input.shape.width + conv.stride - 1) / conv.stride;
  conv.first_row = first;
  conv.rows = rows;
  return conv;
}

void ConvLayer::relu(const Tensor& input, const Tensor& output, std::int32_t first,
                     std::int32_t rows) const noexcept {
  relu(input, output.origin, output.shape.channels, output.shape.row_stride(), first, rows);
}

void ConvLayer::relu(const Tensor& input, std::uint8_t* output, std::int32_t pixel_stride,
                     std::int32_t row_stride, std::int32_t first, std::int32_t rows) const noexcept {
  ConvU8S8 conv = call(input, first, rows);
  conv.epilogue = ConvEpilogue::kRelu;
  conv.output = output;
  conv.output_row_stride = row_stride;
  conv.output_pixel_stride = pixel_stride;
  run_(conv);
}

void ConvLayer::add(const Tensor& input, const Tensor& sum, std::int32_t first,
                    std::int32_t rows) const noexcept {
  ConvU8S8 conv = call(input, first, rows);
  conv.epilogue = ConvEpilogue::kAdd;
  conv.addend = sum.origin;
  conv.addend_row_stride = sum.shape.row_stride();
  conv.addend_pixel_stride = sum.shape.channels;
  conv.output = sum.origin;
  conv.output_row_stride = conv.addend_row_stride;
  conv.output_pixel_stride = conv.addend_pixel_stride;
  run_(conv);
}

void ConvLayer::small(const Tensor& input, std::int8_t* output, std::int32_t first,
                      std::int32_t rows) const noexcept {
  ConvU8S8 conv = call(input, first, rows);
  conv.epilogue = ConvEpilogue::kSmall;
  conv.output = output;
  conv.output_row_stride = conv.columns * conv.out_channels;
  conv.output_pixel_stride = conv.out_channels;
  run_(conv);
}

void ConvLayer::scores(const Tensor& input, std::int16_t* output, std::int32_t pixel_stride,
                       std::int32_t row_stride, std::int32_t first, std::int32_t rows) const noexcept {
  ConvU8S8 conv = call(input, first, rows);
  conv.epilogue = ConvEpilogue::kScore;
  conv.output = output;
  conv.output_row_stride = row_stride;
  conv.output_pixel_stride = pixel_stride;
  run_(conv);
}

void ConvLayer::scores(const std::uint8_t* input, std::int32_t row_stride, std::int32_t height,
                       std::int32_t width, std::int16_t* output) const noexcept {
  EGOFOCUS_CHECK(conv_.side == 1 && conv_.stride == 1);
  ConvU8S8 conv = conv_;
  conv.epilogue = ConvEpilogue::kScore;
  conv.input = input;
  conv.input_rows = height;
  conv.input_row_stride = row_stride;
  conv.input_pixel_stride = conv.in_channels;
  conv.columns = width;
  conv.rows = height;
  conv.output = output;
  conv.output_pixel_stride = 2 * conv.out_channels;
  conv.output_row_stride = width * conv.output_pixel_stride;
  run_(conv);
}

}  // namespace egofocus
