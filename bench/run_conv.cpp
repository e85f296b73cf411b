// Runs one body of conv_u8s8 on one layer, so that count_instructions.py can count it: the difference of two
// numbers of calls is what warm calls take.
//   run_conv             lists "BODY LAYER MULTIPLY-ADDS TIMES-IN-A-TICK OF", a line each; OF: a model, or
//                        `compared`
//   run_conv BODY LAYER CALLS
#include <cstdio>
#include <cstdlib>
#include <string>

#include "conv_layers.hpp"

using namespace egofocus;
using namespace egofocus::bench;

namespace {

struct Body {
  const char* name;
  ConvU8S8Function* run;
  ConvPacking packing;
};

constexpr Body kBodies[] = {
#define EGOFOCUS_CONV_U8S8(suffix, isa, tile_outputs, group_inputs) \
  {#suffix, &conv_u8s8_##suffix, kConvPacking_##suffix},
#include "kernels/conv_u8s8.inc"
#undef EGOFOCUS_CONV_U8S8
};

template <typename Visit>
void each_layer(Visit visit) {
  for (const ConvLayer& layer : kComparedConvLayers) visit(layer, "compared");
  for (const ConvLayer& layer : kConvLayers) visit(layer, "base");
  for (const ConvLayer& layer : kSmallConvLayers) visit(layer, "small");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 1 && argc != 4) {
    std::fprintf(stderr, "usage: run_conv [BODY LAYER CALLS]\n");
    return 1;
  }
  bool found = argc == 1;
  for (const Body& body : kBodies) {
    each_layer([&](const ConvLayer& layer, const char* of) {
      if (argc == 1) {
        const ConvLoad load(layer, body.packing);
        std::printf("%s %s %.0f %d %s\n", body.name, layer.name, load.multiplications(), layer.times, of);
      } else if (body.name == std::string(argv[1]) && layer.name == std::string(argv[2])) {
        const ConvLoad load(layer, body.packing);
        found = true;
        for (int call = std::atoi(argv[3]); call > 0; --call) body.run(load.conv());
      }
    });
  }
  if (!found) std::fprintf(stderr, "run_conv: no body %s with a layer %s\n", argv[1], argv[2]);
  return found ? 0 : 1;
}
