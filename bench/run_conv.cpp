// Runs one body of conv_u8s8 or depthwise_u8s8 on one layer, so that count_instructions.py can count it: the
// difference of two numbers of calls is what warm calls take.
//   run_conv             lists "BODY LAYER MULTIPLY-ADDS TIMES-IN-A-TICK OF", a line each; OF: a model, or
//                        `compared`
//   run_conv BODY LAYER CALLS
#include <cstdio>
#include <cstdlib>
#include <string>

#include "conv_layers.hpp"
#include "depthwise_layers.hpp"

using namespace egofocus;
using namespace egofocus::bench;

namespace {

template <class Function, class Packing>
struct Body {
  const char* name;
  Function* run;
  Packing packing;
};

constexpr Body<ConvU8S8Function, ConvPacking> kConvBodies[] = {
#define EGOFOCUS_CONV_U8S8(suffix, isa, tile_outputs, group_inputs) \
  {#suffix, &conv_u8s8_##suffix, kConvPacking_##suffix},
#include "kernels/conv_u8s8.inc"
#undef EGOFOCUS_CONV_U8S8
};

constexpr Body<DepthwiseU8S8Function, DepthwisePacking> kDepthwiseBodies[] = {
#define EGOFOCUS_DEPTHWISE_U8S8(suffix, isa, block_channels, by_columns) \
  {#suffix, &depthwise_u8s8_##suffix, kDepthwisePacking_##suffix},
#include "kernels/depthwise_u8s8.inc"
#undef EGOFOCUS_DEPTHWISE_U8S8
};

struct Wanted {
  std::string body, layer;  // empty: list all
  int calls = 0;
};

/// Whether it was among these.
template <class Load, class Bodies, class Layers>
bool run(const Bodies& bodies, const Layers& layers, const char* of, const Wanted& wanted) {
  bool found = false;
  for (const auto& body : bodies) {
    for (const auto& layer : layers) {
      if (!wanted.body.empty() && (wanted.body != body.name || wanted.layer != layer.name)) continue;
      const Load load(layer, body.packing);
      found = true;
      if (wanted.body.empty()) {
        int of_tick = 0;
        if constexpr (requires { layer.times; }) of_tick = layer.times;
        std::printf("%s %s %.0f %d %s\n", body.name, layer.name, load.multiplications(), of_tick, of);
      }
      for (int call = 0; call < wanted.calls; ++call) load.run(body.run);
    }
  }
  return found;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 1 && argc != 4) {
    std::fprintf(stderr, "usage: run_conv [BODY LAYER CALLS]\n");
    return 1;
  }
  Wanted wanted;
  if (argc == 4) wanted = {argv[1], argv[2], std::atoi(argv[3])};
  const bool compared = run<ConvLoad>(kConvBodies, kComparedConvLayers, "compared", wanted);
  const bool base = run<ConvLoad>(kConvBodies, kConvLayers, "base", wanted);
  const bool small = run<ConvLoad>(kConvBodies, kSmallConvLayers, "small", wanted);
  const bool depthwise = run<DepthwiseLoad>(kDepthwiseBodies, kDepthwiseLayers, "compared", wanted);
  if (compared || base || small || depthwise) return 0;
  std::fprintf(stderr, "run_conv: no body %s with a layer %s\n", argv[1], argv[2]);
  return 1;
}
