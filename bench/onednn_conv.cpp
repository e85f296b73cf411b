#include "onednn_conv.hpp"

#include <omp.h>

#include <algorithm>

namespace egofocus::bench {
namespace {

using Tag = dnnl::memory::format_tag;
using Type = dnnl::memory::data_type;

Type output_type(ConvEpilogue epilogue) {
  switch (epilogue) {
    case ConvEpilogue::kSmall:
      return Type::s8;
    case ConvEpilogue::kScore:
      return Type::s32;
    default:
      return Type::u8;
  }
}

}  // namespace

bool limit_onednn(Isa isa) {
  omp_set_num_threads(1);
  dnnl::cpu_isa tier = dnnl::cpu_isa::sse41;
  if (isa == Isa::kAvx2) tier = dnnl::cpu_isa::avx2;
  if (isa == Isa::kAvxVnni) tier = dnnl::cpu_isa::avx2_vnni;
  if (isa == Isa::kAvx512Vnni) tier = dnnl::cpu_isa::avx512_core_vnni;
  return dnnl::set_max_cpu_isa(tier) == dnnl::status::success && dnnl::get_effective_cpu_isa() == tier;
}

std::string onednn_version() {
  const dnnl_version_t* version = dnnl::version();
  return std::to_string(version->major) + "." + std::to_string(version->minor) + "." +
         std::to_string(version->patch);
}

OneDnnConv::OneDnnConv(const ConvLayer& layer, const ConvLoad& load)
    : engine_(dnnl::engine::kind::cpu, 0), stream_(engine_), conv_(load.conv()) {
  const dnnl::memory::dims in{1, layer.in_channels, load.input_rows(), load.input_columns()};
  const dnnl::memory::dims out{1, layer.out_channels, layer.rows, layer.columns};
  const dnnl::memory::dims window{layer.out_channels, layer.in_channels, layer.side, layer.side};
  const dnnl::memory::dims stride{layer.stride, layer.stride};
  const dnnl::memory::dims gap{layer.dilation - 1, layer.dilation - 1};
  const std::int32_t border = layer.side / 2 * layer.dilation;
  const dnnl::memory::dims padding{border, border};
  const Type type = output_type(layer.epilogue);
  const dnnl::convolution_forward::desc wanted(
      dnnl::prop_kind::forward_inference, dnnl::algorithm::convolution_direct, {in, Type::u8, Tag::any},
      {window, Type::s8, Tag::any}, {{layer.out_channels}, Type::s32, Tag::any}, {out, type, Tag::any},
      stride, gap, padding, padding);
  dnnl::primitive_attr attributes;
  attributes.set_output_scales(
      1 << 1, std::vector<float>(load.given().scale, load.given().scale + layer.out_channels));
  if (layer.epilogue == ConvEpilogue::kAdd) {
    dnnl::post_ops sum;
    sum.append_sum(1.0f);
    attributes.set_post_ops(sum);
  }
  const dnnl::convolution_forward::primitive_desc chosen(wanted, attributes, engine_);
  implementation_ = chosen.impl_info_str();
  primitive_ = dnnl::convolution_forward(chosen);
  input_ = dnnl::memory(chosen.src_desc(), engine_);
  weights_ = dnnl::memory(chosen.weights_desc(), engine_);
  bias_ = dnnl::memory(chosen.bias_desc(), engine_);
  output_ = dnnl::memory(chosen.dst_desc(), engine_);
  given_output_ = {out, type, Tag::nhwc};
  put_operands(load);
  arguments_ = {
      {DNNL_ARG_SRC, input_}, {DNNL_ARG_WEIGHTS, weights_}, {DNNL_ARG_BIAS, bias_}, {DNNL_ARG_DST, output_}};
}

void OneDnnConv::bring(dnnl::memory& from, dnnl::memory& to) {
  dnnl::reorder(from, to).execute(stream_, from, to);
  stream_.wait();
}

void OneDnnConv::put_operands(const ConvLoad& load) {
  const auto given = [this](const dnnl::memory& like, Type type, Tag tag, const void* from) {
    return dnnl::memory({like.get_desc().dims(), type, tag}, engine_, const_cast<void*>(from));
  };
  std::vector<std::uint8_t> inside;
  for (std::int32_t y = 0; y < load.input_rows(); ++y) {
    const std::uint8_t* row = conv_.input + y * conv_.input_row_stride;
    inside.insert(inside.end(), row, row + load.input_columns() * conv_.in_channels);
  }
  dnnl::memory input = given(input_, Type::u8, Tag::nhwc, inside.data());
  dnnl::memory weights = given(weights_, Type::s8, Tag::ohwi, load.given().weights);
  dnnl::memory bias = given(bias_, Type::s32, Tag::a, load.given().bias);
  bring(input, input_);
  bring(weights, weights_);
  bring(bias, bias_);
}

void OneDnnConv::put_addend() {
  dnnl::memory addend(given_output_, engine_, const_cast<std::uint8_t*>(conv_.addend));
  bring(addend, output_);
}

std::vector<std::int32_t> OneDnnConv::outputs() {
  if (conv_.epilogue == ConvEpilogue::kAdd) put_addend();
  run();
  stream_.wait();
  dnnl::memory dense(given_output_, engine_);
  bring(output_, dense);
  const std::size_t count = static_cast<std::size_t>(conv_.rows * conv_.columns * conv_.out_channels);
  std::vector<std::int32_t> values(count);
  const void* from = dense.get_data_handle();
  for (std::size_t i = 0; i < count; ++i) {
    switch (conv_.epilogue) {
      case ConvEpilogue::kSmall:
        values[i] = static_cast<const std::int8_t*>(from)[i];
        break;
      case ConvEpilogue::kScore:
        values[i] = std::clamp(static_cast<const std::int32_t*>(from)[i], -32768, 32767);
        break;
      default:
        values[i] = std::min<std::int32_t>(static_cast<const std::uint8_t*>(from)[i], 127);
        break;
    }
  }
  return values;
}

}  // namespace egofocus::bench
