// A model file (.efm, docs/formats.md): the trained network's integers and what it wants to be told. Views
// into the caller's bytes, checked as those of a stranger: whatever reads them afterwards may run blind.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "egofocus/config.hpp"
#include "egofocus/status.hpp"
#include "pipeline/focus_input.hpp"

namespace egofocus {

/// What the network is built of and was trained with.
struct ModelFacts {
  static constexpr std::int32_t kMostDilations = 8;
  LadderConfig ladder;  ///< z_near_m is not the model's: the default
  std::int32_t max_events = 0;
  FocusInputConfig input;
  std::int32_t grid_width_px = 0;  ///< the only grid that it is for; 0: any
  std::int32_t grid_height_px = 0;
  std::int32_t focus_layers = 0;   ///< convolutions per hypothesis: 1 or 2
  std::int32_t cost_hidden = 0;    ///< channels between the two
  std::int32_t cost_channels = 0;  ///< per hypothesis: even; all other channels inside are multiples of 4
  std::int32_t widths[3] = {};     ///< channels at 1/4, 1/8, 1/16
  std::int32_t blocks[3] = {};     ///< residual blocks on the way down
  std::int32_t up_blocks[2] = {};  ///< on the way up, at 1/4 and 1/8
  std::int32_t refine_width = 0;
  std::int32_t dilation_count = 0;
  std::int32_t dilations[kMostDilations] = {};  ///< 1..4
};

/// The network's convolutions in the order they run.
enum class LayerRole : std::uint8_t {
  kFocusCost,
  kMix,
  kAt4,
  kDown8,
  kAt8,
  kDown16,
  kAt16,
  kNarrow16,
  kUp8,
  kNarrow8,
  kUp4,
  kHead,
  kOwn,
  kGuide,
  kFirst,
  kBody,
  kLast,
};
inline constexpr std::size_t kLayerRoles = 17;
const char* to_string(LayerRole role) noexcept;

/// outputs x inputs x side x side; padded by side / 2 * dilation pixels of the byte `zero`, which the biases
/// know.
struct LayerShape {
  std::int32_t outputs = 0;
  std::int32_t inputs = 0;
  std::int32_t side = 1;
  std::int32_t stride = 1;
  std::int32_t dilation = 1;
  std::int32_t zero = 0;
  friend bool operator==(const LayerShape&, const LayerShape&) noexcept = default;
};

struct ModelLayer {
  LayerRole role = LayerRole::kFocusCost;
  LayerShape shape;
  const std::int8_t* weights = nullptr;  ///< [outputs][y][x][inputs], -127..127
  const std::int32_t* bias = nullptr;    ///< [outputs], within +-2^30
  const float* scale = nullptr;          ///< [outputs], 2^-40 <= scale < 1
};

struct Model {
  static constexpr std::int32_t kVersion = 1;
  static constexpr std::size_t kAlignment = 16;
  static constexpr std::int32_t kMostLayers = 128;

  ModelFacts facts;
  std::string_view card;  ///< lines of text, `key: value`
  std::int32_t layer_count = 0;
  ModelLayer layers[kMostLayers];
  std::int32_t first_layer[kLayerRoles] = {};  ///< of each role

  [[nodiscard]] const ModelLayer& layer(LayerRole role, std::int32_t n = 0) const noexcept {
    return layers[first_layer[static_cast<std::size_t>(role)] + n];
  }
};

/// The shapes that a network of these facts has, in order; returns their number. Precondition: read_model()
/// accepted the facts.
std::int32_t layer_shapes(const ModelFacts& facts, std::span<ModelLayer> out) noexcept;

/// Reads and checks. `bytes` begin at a multiple of Model::kAlignment and outlive the model; they may go on
/// beyond its end, as an embedded array's do. Errors: kBadModel (damaged, or no model; value = the place, a
/// byte counted from the begin), kUnsupportedModel (version or operator; value = found, bound = known).
/// Thread: any. RT: no (set-up), O(bytes).
Status read_model(std::span<const std::byte> bytes, Model& out) noexcept;

}  // namespace egofocus
