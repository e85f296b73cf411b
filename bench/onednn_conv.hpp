// A convolution as oneDNN does it: its own choice of implementation and layouts (format_tag::any), the
// primitive made once, operands brought into its layouts once.
#pragma once

#include <cstdint>
#include <dnnl.hpp>
#include <string>
#include <vector>

#include "conv_layers.hpp"
#include "depthwise_layers.hpp"
#include "kernels/isa.hpp"

namespace egofocus::bench {

/// One thread, and nothing beyond the tier of `isa` (kSse41, kAvx2, kAvxVnni or kAvx512Vnni): before anything
/// else of oneDNN, once in a process. False where that is too late.
bool limit_onednn(Isa isa);

/// The version of the library that runs.
std::string onednn_version();

/// A layer in oneDNN's words. The addend and `input` have their channels innermost and no gap.
struct OneDnnProblem {
  dnnl::memory::dims in, out, window, stride, gap, padding;
  dnnl::memory::format_tag pixels, weights;
  ConvEpilogue epilogue = ConvEpilogue::kRelu;
  std::vector<std::uint8_t> input;
  const std::int8_t* given_weights = nullptr;
  const std::int32_t* bias = nullptr;
  const float* scale = nullptr;
  const std::uint8_t* addend = nullptr;
};
OneDnnProblem problem_of(const ConvLoad& load);
OneDnnProblem problem_of(const DepthwiseLoad& load);

/// u8 input, s8 weights with a scale per output, s32 bias. kRelu leaves as u8, kSmall as s8, kScore as s32
/// (oneDNN has no s16), kAdd is the sum post-op on u8: each once for all outputs, without ours' clamp at 127.
/// Throws dnnl::error.
class OneDnnConv {
 public:
  explicit OneDnnConv(const OneDnnProblem& problem);
  void run() { primitive_.execute(stream_, arguments_); }
  /// Of a run on the problem's operands, clamped as ours are, channels innermost.
  std::vector<std::int32_t> outputs();
  /// As oneDNN names it.
  const std::string& implementation() const { return implementation_; }

 private:
  void put_operands(const OneDnnProblem& problem);
  void bring(dnnl::memory& from, dnnl::memory& to);

  dnnl::engine engine_;
  dnnl::stream stream_;
  ConvEpilogue epilogue_;
  const std::uint8_t* addend_;
  dnnl::memory::desc given_output_;  // dense, channels innermost
  std::size_t output_count_ = 1;
  dnnl::memory input_, weights_, bias_, output_;
  dnnl::convolution_forward primitive_;
  std::unordered_map<int, dnnl::memory> arguments_;
  std::string implementation_;
};

}  // namespace egofocus::bench
