#include "pipeline/network.hpp"

namespace egofocus {
namespace {

constexpr std::int32_t kRefineChannels = 8;
constexpr std::int32_t kGuideChannels = 4;

constexpr std::int32_t up_to_multiple(std::int32_t value, std::int32_t of) noexcept {
  return (value + of - 1) / of * of;
}

// Hypotheses that one convolution looks at, so that their channels are a multiple of 4.
constexpr std::int32_t at_once(const ModelFacts& facts) noexcept {
  return facts.cost_channels % 4 == 0 ? 1 : 2;
}

constexpr std::int32_t half(std::int32_t size) noexcept {
  return (size + 1) / 2;
}

}  // namespace

Network::Buffers::Buffers(const ModelFacts& facts, const Intrinsics& grid, int parts,
                          MemoryPlan& plan) noexcept {
  const EnergyGrid cells = energy_grid(grid.width_px, grid.height_px);
  const std::int32_t w4 = cells.width, h4 = cells.height;
  const std::int32_t w8 = half(w4), h8 = half(h4), w16 = half(w8), h16 = half(h8);
  const std::int32_t w2 = half(grid.width_px), h2 = half(grid.height_px);
  const std::int32_t depth = facts.ladder.hypotheses;
  at_4 = {w4, h4, facts.widths[0], 1};
  at_8 = {w8, h8, facts.widths[1], 1};
  at_16 = {w16, h16, facts.widths[2], 1};
  const std::int32_t in_channels = up_to_multiple(facts.input.map_count, 4);
  focus_in = {w4, h4, facts.focus_layers == 2 ? in_channels : at_once(facts) * in_channels, 1};
  focus_hidden = {w4, h4, at_once(facts) * facts.cost_hidden, 1};
  // Multiples of 16: the widest registers' loads of inputs do not straddle pixels.
  mixed = {w4, h4, up_to_multiple(depth * facts.cost_channels + facts.input.map_count + 6, 16), 0};
  std::int32_t reach = 1;
  for (std::int32_t i = 0; i < facts.dilation_count; ++i)
    reach = facts.dilations[i] > reach ? facts.dilations[i] : reach;
  refine_in = {w2, h2, kRefineChannels, 1};
  refine = {w2, h2, facts.refine_width, reach};
  guide = {w4, h4, kGuideChannels, 0};

  const auto dense = [](const TensorShape& shape) noexcept {
    return static_cast<std::size_t>(shape.width * shape.height);
  };
  for (int i = 0; i < parts; ++i) {
    focus_in_id[i] = plan.add(focus_in.bytes(), kStepFocusCost, kStepFocusCost);
    focus_hidden_id[i] = plan.add(focus_hidden.bytes(), kStepFocusCost, kStepFocusCost);
    scores_id[i] = plan.add(static_cast<std::size_t>(w4 * depth) * 4, kStepScores, kStepScores);
  }
  mixed_id = plan.add(mixed.bytes(), kStepFocusCost, kStepScores);
  at_4_id = plan.add(at_4.bytes(), kStepMix, kStepRefine);
  inner_4_id = plan.add(at_4.bytes(), kStepAt4, kStepAt4);
  at_8_id = plan.add(at_8.bytes(), kStepAt8, kStepUp4);
  inner_8_id = plan.add(at_8.bytes(), kStepAt8, kStepAt8);
  at_16_id = plan.add(at_16.bytes(), kStepAt16, kStepUp8);
  inner_16_id = plan.add(at_16.bytes(), kStepAt16, kStepAt16);
  small_8_id = plan.add(dense(at_16) * static_cast<std::size_t>(at_8.channels), kStepUp8, kStepUp8);
  inner_up_8_id = plan.add(at_8.bytes(), kStepUp8, kStepUp8);
  small_4_id = plan.add(dense(at_8) * static_cast<std::size_t>(at_4.channels), kStepUp4, kStepUp4);
  inner_up_4_id = plan.add(at_4.bytes(), kStepUp4, kStepUp4);
  index_4_id = plan.add(2 * dense(at_4), kStepScores, kStepRefine);
  confidence_4_id = plan.add(dense(at_4), kStepScores, kStepRefine);
  spread_4_id = plan.add(2 * dense(at_4), kStepScores, kStepRefine);
  guide_id = plan.add(guide.bytes(), kStepRefine, kStepRefine);
  start_id = plan.add(2 * dense(refine), kStepRefine, kStepRefine);
  change_id = plan.add(2 * dense(refine), kStepRefine, kStepRefine);
  refine_in_id = plan.add(refine_in.bytes(), kStepRefine, kStepRefine);
  for (std::int32_t& id : refine_id) id = plan.add(refine.bytes(), kStepRefine, kStepRefine);
  index_id = plan.add(2 * dense(refine), kStepRefine, kStepRefine);
  confidence_id = plan.add(dense(refine), kStepRefine, kStepRefine);
}

Network::Blocks Network::make_blocks(const Model& model, LayerRole role, std::int32_t count,
                                     std::int32_t width, const KernelTable& kernels, Arena& arena) noexcept {
  Blocks blocks;
  blocks.count = count;
  for (std::int32_t i = 0; i < count; ++i) {
    blocks.of[i].first = ConvLayer(model.layer(role, 2 * i), width, kernels, arena);
    blocks.of[i].second = ConvLayer(model.layer(role, 2 * i + 1), width, kernels, arena);
  }
  return blocks;
}

Network::Network(const Model& model, const Intrinsics& grid, const KernelTable& kernels, int parts,
                 const Buffers& buffers, const MemoryPlan& plan, Arena& arena) noexcept
    : facts_(model.facts),
      together_(at_once(facts_)),
      cells_(energy_grid(grid.width_px, grid.height_px)),
      halves_(cell_grid(grid)) {
  const auto layer = [&](LayerRole role, std::int32_t channels, std::int32_t n = 0,
                         std::int32_t copies = 1) noexcept {
    return ConvLayer(model.layer(role, n), channels, kernels, arena, copies);
  };
  const auto [w4, w8, w16] = facts_.widths;
  arena.part(ArenaPart::kWeights);
  const std::int32_t last_focus = facts_.focus_layers - 1;
  if (last_focus == 1) focus_layers_[0] = layer(LayerRole::kFocusCost, buffers.focus_in.channels);
  focus_layers_[last_focus] =
      layer(LayerRole::kFocusCost, (last_focus == 1 ? buffers.focus_hidden : buffers.focus_in).channels,
            last_focus, together_);
  mix_ = layer(LayerRole::kMix, buffers.mixed.channels);
  blocks_4_ = make_blocks(model, LayerRole::kAt4, facts_.blocks[0], w4, kernels, arena);
  down_8_ = layer(LayerRole::kDown8, w4);
  blocks_8_ = make_blocks(model, LayerRole::kAt8, facts_.blocks[1], w8, kernels, arena);
  down_16_ = layer(LayerRole::kDown16, w8);
  blocks_16_ = make_blocks(model, LayerRole::kAt16, facts_.blocks[2], w16, kernels, arena);
  narrow_16_ = layer(LayerRole::kNarrow16, w16);
  blocks_up_8_ = make_blocks(model, LayerRole::kUp8, facts_.up_blocks[1], w8, kernels, arena);
  narrow_8_ = layer(LayerRole::kNarrow8, w8);
  blocks_up_4_ = make_blocks(model, LayerRole::kUp4, facts_.up_blocks[0], w4, kernels, arena);
  head_ = layer(LayerRole::kHead, w4);
  own_ = layer(LayerRole::kOwn, together_ * facts_.cost_channels, 0, together_);
  guide_ = layer(LayerRole::kGuide, w4);
  first_ = layer(LayerRole::kFirst, kRefineChannels);
  for (std::int32_t i = 0; i < facts_.dilation_count; ++i)
    body_[i] = layer(LayerRole::kBody, facts_.refine_width, i);
  last_ = layer(LayerRole::kLast, facts_.refine_width);

  const auto tensor = [&](const TensorShape& shape, std::int32_t id) noexcept {
    return Tensor(shape, plan.arena(id));
  };
  for (int i = 0; i < parts; ++i) {
    focus_in_[i] = tensor(buffers.focus_in, buffers.focus_in_id[i]);
    focus_hidden_[i] = tensor(buffers.focus_hidden, buffers.focus_hidden_id[i]);
    scores_[i] =
        plan.arena(buffers.scores_id[i])
            .array<std::int16_t>(2 * static_cast<std::size_t>(cells_.width * facts_.ladder.hypotheses))
            .data();
  }
  mixed_ = tensor(buffers.mixed, buffers.mixed_id);
  at_4_ = tensor(buffers.at_4, buffers.at_4_id);
  inner_4_ = tensor(buffers.at_4, buffers.inner_4_id);
  inner_up_4_ = tensor(buffers.at_4, buffers.inner_up_4_id);
  at_8_ = tensor(buffers.at_8, buffers.at_8_id);
  inner_8_ = tensor(buffers.at_8, buffers.inner_8_id);
  inner_up_8_ = tensor(buffers.at_8, buffers.inner_up_8_id);
  at_16_ = tensor(buffers.at_16, buffers.at_16_id);
  inner_16_ = tensor(buffers.at_16, buffers.inner_16_id);
  guide_4_ = tensor(buffers.guide, buffers.guide_id);
  refine_in_ = tensor(buffers.refine_in, buffers.refine_in_id);
  for (int i = 0; i < 2; ++i) refine_[i] = tensor(buffers.refine, buffers.refine_id[i]);
  const auto cells = [](const TensorShape& shape) noexcept {
    return static_cast<std::size_t>(shape.width * shape.height);
  };
  small_8_ = plan.arena(buffers.small_8_id)
                 .array<std::int8_t>(cells(buffers.at_16) * static_cast<std::size_t>(w8))
                 .data();
  small_4_ = plan.arena(buffers.small_4_id)
                 .array<std::int8_t>(cells(buffers.at_8) * static_cast<std::size_t>(w4))
                 .data();
  index_4_ = plan.arena(buffers.index_4_id).array<std::uint16_t>(cells_.size()).data();
  confidence_4_ = plan.arena(buffers.confidence_4_id).array<std::uint8_t>(cells_.size()).data();
  spread_4_ = plan.arena(buffers.spread_4_id).array<std::uint16_t>(cells_.size());
  start_ = plan.arena(buffers.start_id).array<std::uint16_t>(halves_.size()).data();
  change_ = plan.arena(buffers.change_id).array<std::int16_t>(halves_.size()).data();
  index_q8_ = plan.arena(buffers.index_id).array<std::uint16_t>(halves_.size());
  confidence_ = plan.arena(buffers.confidence_id).array<std::uint8_t>(halves_.size());
}

}  // namespace egofocus
