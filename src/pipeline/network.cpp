#include "pipeline/network.hpp"

#include "core/check.hpp"
#include "kernels/requant.hpp"
#include "pipeline/in_parts.hpp"
#include "pipeline/up_sample.hpp"

namespace egofocus {
namespace {

// A row of `count` planes, a pixel's bytes side by side, `stride` to the next one's. Channels that have no
// plane have no weights either: they repeat the first.
template <std::int32_t kChannels>
void interleave(const std::uint8_t* planes, std::size_t plane_size, std::int32_t count, std::int32_t width,
                std::int32_t stride, std::uint8_t* __restrict to) noexcept {
  const std::uint8_t* from[kChannels];
  for (std::int32_t c = 0; c < kChannels; ++c)
    from[c] = planes + (c < count ? static_cast<std::size_t>(c) * plane_size : 0);
  if (stride == kChannels) {  // vector units interleave where there are no gaps
    for (std::int32_t x = 0; x < width; ++x)
      for (std::int32_t c = 0; c < kChannels; ++c) to[x * kChannels + c] = from[c][x];
  } else {
    for (std::int32_t x = 0; x < width; ++x)
      for (std::int32_t c = 0; c < kChannels; ++c) to[x * stride + c] = from[c][x];
  }
}

}  // namespace

CellDepth Network::run(const NetworkInputs& inputs, WorkerPool& pool) noexcept {
  EGOFOCUS_CHECK(inputs.used >= 1 && inputs.used <= facts_.ladder.hypotheses);
  inputs_ = inputs;
  in_parts(pool, [this](int part, int parts) noexcept { focus_costs(part, parts); });
  at_4_.fill_border(0);
  in_parts(pool, [this](int part, int parts) noexcept { mix(part, parts); });
  show("mixed", mixed_);
  run_blocks(blocks_4_, at_4_, inner_4_, pool);
  show("a4", at_4_);
  down(down_8_, at_4_, at_8_, pool);
  run_blocks(blocks_8_, at_8_, inner_8_, pool);
  show("a8", at_8_);
  down(down_16_, at_8_, at_16_, pool);
  run_blocks(blocks_16_, at_16_, inner_16_, pool);
  show("a16", at_16_);
  join(narrow_16_, at_16_, at_8_, small_8_, pool);
  run_blocks(blocks_up_8_, at_8_, inner_up_8_, pool);
  show("b8", at_8_);
  join(narrow_8_, at_8_, at_4_, small_4_, pool);
  run_blocks(blocks_up_4_, at_4_, inner_up_4_, pool);
  show("b4", at_4_);
  in_parts(pool, [this](int part, int parts) noexcept { scores(part, parts); });
  show("index_4", {{cells_.width, cells_.height, 2, 0}, reinterpret_cast<std::uint8_t*>(index_4_)});
  show("confidence", {{cells_.width, cells_.height, 1, 0}, confidence_4_});
  refine(pool);
  return {halves_, index_q8_, confidence_, false, spread_4_};
}

void Network::show(const char* name, const Tensor& tensor) const noexcept {
  if (watcher_.bytes != nullptr) watcher_.bytes(watcher_.self, name, tensor);
}

// C_k = relu conv(relu conv(focus_k)) of this part's hypotheses, straight to its channels in `mixed`. The
// last layer looks at `together` of them at once.
void Network::focus_costs(int part, int parts) noexcept {
  const std::int32_t groups = facts_.ladder.hypotheses / together_;
  const bool two_layers = facts_.focus_layers == 2;
  const Tensor& in = focus_in_[part];
  const Tensor& hidden = focus_hidden_[part];
  in.fill_border(kInputZero);
  if (two_layers) hidden.fill_border(0);
  for (std::int32_t group = groups * part / parts; group < groups * (part + 1) / parts; ++group) {
    for (std::int32_t i = 0; i < together_; ++i) {
      take_maps(group * together_ + i, in, two_layers ? 0 : i * (in.shape.channels / together_));
      if (two_layers)
        focus_layers_[0].relu(in, hidden.origin + i * facts_.cost_hidden, hidden.shape.channels,
                              hidden.shape.row_stride(), 0, cells_.height);
    }
    focus_layers_[facts_.focus_layers - 1].relu(
        two_layers ? hidden : in, mixed_.origin + group * together_ * facts_.cost_channels,
        mixed_.shape.channels, mixed_.shape.row_stride(), 0, cells_.height);
  }
}

// The maps of hypothesis k to channels `first` and the following of `to`.
void Network::take_maps(std::int32_t k, const Tensor& to, std::int32_t first) const noexcept {
  const std::int32_t maps = facts_.input.map_count;
  const std::int32_t stride = to.shape.channels;
  const std::uint8_t* plane =
      inputs_.focus.data() + static_cast<std::size_t>(k) * static_cast<std::size_t>(maps) * cells_.size();
  for (std::int32_t y = 0; y < cells_.height; ++y, plane += cells_.width) {
    if (maps <= 4) {
      interleave<4>(plane, cells_.size(), maps, cells_.width, stride, to.row(y) + first);
    } else {
      interleave<8>(plane, cells_.size(), maps, cells_.width, stride, to.row(y) + first);
    }
  }
}

void Network::mix(int part, int parts) noexcept {
  const std::int32_t first = cells_.height * part / parts;
  const std::int32_t end = cells_.height * (part + 1) / parts;
  const std::int32_t of_cost = facts_.ladder.hypotheses * facts_.cost_channels;
  const std::int32_t context = facts_.input.map_count + 6;
  for (std::int32_t y = first; y < end; ++y) {
    const std::uint8_t* from = inputs_.context.data() + static_cast<std::size_t>(y * cells_.width);
    std::uint8_t* to = mixed_.row(y) + of_cost;
    for (std::int32_t x = 0; x < cells_.width; ++x, ++from, to += mixed_.shape.channels) {
      for (std::int32_t i = 0; i < context; ++i) to[i] = from[static_cast<std::size_t>(i) * cells_.size()];
      for (std::int32_t i = context; i < mixed_.shape.channels - of_cost; ++i) to[i] = 0;
    }
  }
  mix_.relu(mixed_, at_4_, first, end - first);
}

// x = add conv(relu conv(x)) to x, where it lies: the second convolution looks at `inner` alone.
void Network::run_blocks(const Blocks& blocks, const Tensor& sum, const Tensor& inner,
                         WorkerPool& pool) noexcept {
  if (blocks.count > 0) inner.fill_border(0);
  for (std::int32_t i = 0; i < blocks.count; ++i) {
    const Block& block = blocks.of[i];
    by_rows(pool, sum.shape.height, [&](std::int32_t first, std::int32_t rows) noexcept {
      block.first.relu(sum, inner, first, rows);
    });
    by_rows(pool, sum.shape.height, [&](std::int32_t first, std::int32_t rows) noexcept {
      block.second.add(inner, sum, first, rows);
    });
  }
}

void Network::down(const ConvLayer& layer, const Tensor& from, const Tensor& to, WorkerPool& pool) noexcept {
  to.fill_border(0);
  by_rows(pool, to.shape.height,
          [&](std::int32_t first, std::int32_t rows) noexcept { layer.relu(from, to, first, rows); });
}

// to = clamp(to + up(small conv(from)))
void Network::join(const ConvLayer& narrow, const Tensor& from, const Tensor& to, std::int8_t* small,
                   WorkerPool& pool) noexcept {
  by_rows(pool, from.shape.height,
          [&](std::int32_t first, std::int32_t rows) noexcept { narrow.small(from, small, first, rows); });
  by_rows(pool, to.shape.height, [&](std::int32_t first, std::int32_t rows) noexcept {
    for (std::int32_t y = first; y < first + rows; ++y) {
      std::uint8_t* const row = to.row(y);
      const std::int32_t channels = to.shape.channels;
      up_sample_row(small, from.shape.width, from.shape.height, channels, y, to.shape.width,
                    [row, channels](std::int32_t x, std::int32_t i, std::int32_t value) noexcept {
                      std::uint8_t& byte = row[x * channels + i];
                      byte = static_cast<std::uint8_t>(clamp_s32(byte + value, 0, 127));
                    });
    }
  });
}

void Network::scores(int part, int parts) noexcept {
  const std::int32_t depth = facts_.ladder.hypotheses;
  std::int16_t* const head = scores_[part];
  std::int16_t* const own = head + cells_.width * depth;
  const std::uint8_t* const shift =
      inputs_.context.data() + static_cast<std::size_t>(facts_.input.map_count + 4) * cells_.size();
  for (std::int32_t y = cells_.height * part / parts; y < cells_.height * (part + 1) / parts; ++y) {
    head_.scores(at_4_, head, depth * 2, 0, y, 1);
    // A cell's costs are a row of pixels to this layer.
    own_.scores(mixed_.row(y), mixed_.shape.channels, cells_.width, depth / together_, own);
    const std::int32_t at = y * cells_.width;
    regression_.row(head, own, shift + at, cells_.width, depth, inputs_.used, index_4_ + at,
                    confidence_4_ + at, spread_4_.data() + at);
  }
}

}  // namespace egofocus
