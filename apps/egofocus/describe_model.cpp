#include "describe_model.hpp"

#include <memory>
#include <vector>

#include "pipeline/model.hpp"
#include "recording/error.hpp"

namespace egofocus::app {
namespace {

using recording::Error;
using recording::ExitCode;

std::string numbers(std::span<const std::int32_t> values) {
  std::string text;
  for (const std::int32_t value : values) text += (text.empty() ? "" : " ") + std::to_string(value);
  return text;
}

std::string maps_text(const FocusInputConfig& input) {
  constexpr const char* kNames[] = {"gradient", "gradient_x", "gradient_y", "squares"};
  std::string text;
  for (std::int32_t m = 0; m < input.map_count; ++m) {
    text += (text.empty() ? "" : " ") + std::string(kNames[static_cast<std::size_t>(input.maps[m].kind)]) +
            ":" + std::to_string(input.maps[m].side);
  }
  return text;
}

Json layer_facts(const ModelLayer& layer) {
  const LayerShape& shape = layer.shape;
  return Json()
      .add("layer", to_string(layer.role))
      .add("kernel", std::to_string(shape.side) + "x" + std::to_string(shape.side))
      .add("stride", shape.stride)
      .add("dilation", shape.dilation)
      .add("inputs", shape.inputs)
      .add("outputs", shape.outputs)
      .add("zero", shape.zero);
}

void add_card(std::string_view card, Json& facts) {
  while (!card.empty()) {
    const std::string_view line = card.substr(0, card.find('\n'));
    card.remove_prefix(std::min(line.size() + 1, card.size()));
    const std::size_t colon = line.find(": ");
    if (colon == std::string_view::npos) {
      if (!line.empty()) facts.add("note", line);
    } else {
      facts.add(std::string(line.substr(0, colon)), line.substr(colon + 2));
    }
  }
}

}  // namespace

Json describe_model(std::span<const std::byte> bytes, const std::string& name) {
  const auto model = std::make_unique<Model>();
  if (const Status status = read_model(bytes, *model); !status.ok()) {
    char reason[200];
    status.describe(reason);
    throw Error(ExitCode::kBadFile, name, reason);
  }
  const ModelFacts& f = model->facts;
  std::size_t parameters = 0;
  std::vector<Json> layers;
  for (std::int32_t i = 0; i < model->layer_count; ++i) {
    const LayerShape& shape = model->layers[i].shape;
    parameters += static_cast<std::size_t>(shape.outputs * shape.inputs * shape.side * shape.side);
    layers.push_back(layer_facts(model->layers[i]));
  }
  Json card;
  add_card(model->card, card);
  Json facts;
  facts.add("kind", "model")
      .add("version", Model::kVersion)
      .add("bytes", bytes.size())
      .add("card", card)
      .add("hypotheses", f.ladder.hypotheses)
      .add("ladder", f.ladder.kind == LadderKind::kParallax ? "parallax" : "metric")
      .add("span_px", f.ladder.span_px)
      .add("min_parallax_px", f.ladder.min_parallax_px)
      .add("max_events", f.max_events)
      .add("maps", maps_text(f.input))
      .add("floor_events", f.input.floor_events_milli / 1000.0)
      .add("floor_noise", f.input.floor_noise_milli / 1000.0)
      .add("grid", f.grid_width_px == 0
                       ? std::string("any")
                       : std::to_string(f.grid_width_px) + "x" + std::to_string(f.grid_height_px))
      .add("widths", numbers(f.widths))
      .add("blocks", numbers(f.blocks))
      .add("up_blocks", numbers(f.up_blocks))
      .add("refine_width", f.refine_width)
      .add("refine_dilations",
           numbers(std::span(f.dilations).first(static_cast<std::size_t>(f.dilation_count))))
      .add("regression", "median")
      .add("weights", parameters)
      .add("layers", layers);
  return facts;
}

}  // namespace egofocus::app
