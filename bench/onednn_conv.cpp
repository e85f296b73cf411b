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

OneDnnProblem problem_of(const ConvLoad& load) {
  const ConvU8S8& conv = load.conv();
  const std::int32_t border = conv.side / 2 * conv.dilation;
  OneDnnProblem problem{{1, conv.in_channels, load.input_rows(), load.input_columns()},
                        {1, conv.out_channels, conv.rows, conv.columns},
                        {conv.out_channels, conv.in_channels, conv.side, conv.side},
                        {conv.stride, conv.stride},
                        {conv.dilation - 1, conv.dilation - 1},
                        {border, border},
                        Tag::nhwc,
                        Tag::ohwi,
                        conv.epilogue,
                        load.dense_input(),
                        load.given().weights,
                        load.given().bias,
                        load.given().scale,
                        conv.addend};
  if (conv.depth == 1) return problem;
  problem.in = {1, conv.in_channels, load.planes(), load.input_rows(), load.input_columns()};
  problem.out = {1, conv.out_channels, load.planes(), conv.rows, conv.columns};
  problem.window = {conv.out_channels, conv.in_channels, conv.depth, conv.side, conv.side};
  problem.stride = {1, conv.stride, conv.stride};
  problem.gap = {0, conv.dilation - 1, conv.dilation - 1};
  problem.padding = {conv.depth / 2, border, border};
  problem.pixels = Tag::ndhwc;
  problem.weights = Tag::odhwi;
  return problem;
}

OneDnnProblem problem_of(const DepthwiseLoad& load) {
  const DepthwiseU8S8& conv = load.conv();
  return {{1, conv.channels, load.input_rows(), load.input_columns()},
          {1, conv.channels, conv.rows, conv.columns},
          {conv.channels, 1, 1, 3, 3},
          {conv.stride, conv.stride},
          {conv.dilation - 1, conv.dilation - 1},
          {conv.dilation, conv.dilation},
          Tag::nhwc,
          Tag::goihw,
          conv.epilogue,
          load.dense_input(),
          load.given().weights,
          load.given().bias,
          load.given().scale,
          conv.addend};
}

OneDnnConv::OneDnnConv(const OneDnnProblem& problem)
    : engine_(dnnl::engine::kind::cpu, 0),
      stream_(engine_),
      epilogue_(problem.epilogue),
      addend_(problem.addend) {
  const std::int64_t channels = problem.out[1];
  const Type type = output_type(epilogue_);
  const dnnl::convolution_forward::desc wanted(
      dnnl::prop_kind::forward_inference, dnnl::algorithm::convolution_direct,
      {problem.in, Type::u8, Tag::any}, {problem.window, Type::s8, Tag::any},
      {{channels}, Type::s32, Tag::any}, {problem.out, type, Tag::any}, problem.stride, problem.gap,
      problem.padding, problem.padding);
  dnnl::primitive_attr attributes;
  attributes.set_output_scales(1 << 1, std::vector<float>(problem.scale, problem.scale + channels));
  if (epilogue_ == ConvEpilogue::kAdd) {
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
  given_output_ = {problem.out, type, problem.pixels};
  for (const std::int64_t size : problem.out) output_count_ *= static_cast<std::size_t>(size);
  put_operands(problem);
  arguments_ = {
      {DNNL_ARG_SRC, input_}, {DNNL_ARG_WEIGHTS, weights_}, {DNNL_ARG_BIAS, bias_}, {DNNL_ARG_DST, output_}};
}

void OneDnnConv::bring(dnnl::memory& from, dnnl::memory& to) {
  dnnl::reorder(from, to).execute(stream_, from, to);
  stream_.wait();
}

void OneDnnConv::put_operands(const OneDnnProblem& problem) {
  const auto put = [this](dnnl::memory& to, const dnnl::memory::dims& dims, Type type, Tag tag,
                          const void* from) {
    dnnl::memory given({dims, type, tag}, engine_, const_cast<void*>(from));
    bring(given, to);
  };
  put(input_, problem.in, Type::u8, problem.pixels, problem.input.data());
  put(weights_, problem.window, Type::s8, problem.weights, problem.given_weights);
  put(bias_, {problem.out[1]}, Type::s32, Tag::a, problem.bias);
}

std::vector<std::int32_t> OneDnnConv::outputs() {
  if (epilogue_ == ConvEpilogue::kAdd) {
    dnnl::memory addend(given_output_, engine_, const_cast<std::uint8_t*>(addend_));
    bring(addend, output_);
  }
  run();
  stream_.wait();
  dnnl::memory dense(given_output_, engine_);
  bring(output_, dense);
  std::vector<std::int32_t> values(output_count_);
  const void* from = dense.get_data_handle();
  for (std::size_t i = 0; i < output_count_; ++i) {
    switch (epilogue_) {
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
