// The network's refinement at 1/2.
#include "kernels/requant.hpp"
#include "pipeline/half_counts.hpp"
#include "pipeline/in_parts.hpp"
#include "pipeline/network.hpp"
#include "pipeline/up_sample.hpp"

namespace egofocus {
namespace {

// Channels of the refinement's input: place, three counts, guide.
constexpr std::int32_t kChannels = 8;
constexpr std::int32_t kGuideAt = 4;
constexpr std::int32_t kGuideChannels = 4;
constexpr std::int32_t kBorder_q8 = 2 * 256;

struct Span {
  std::uint16_t least, most;
};

Span over(Span a, Span b) noexcept {
  return {a.least < b.least ? a.least : b.least, a.most > b.most ? a.most : b.most};
}

}  // namespace

// [place, counts at three hypotheses, guide] of this part's rows.
void Network::refine_input(int part, int parts) noexcept {
  const std::size_t plane_bytes = half_counts_bytes(halves_.size());
  const std::int32_t width = halves_.width;
  for (std::int32_t y = halves_.height * part / parts; y < halves_.height * (part + 1) / parts; ++y) {
    std::uint8_t* const row = refine_in_.row(y);
    std::uint16_t* const start = start_ + y * width;
    up_sample_row<1>(index_4_, cells_.width, cells_.height, 1, y, width,
                     [start](std::int32_t x, std::int32_t, std::int32_t value) noexcept {
                       start[x] = static_cast<std::uint16_t>(value);
                     });
    up_sample_row<kGuideChannels>(guide_4_.origin, cells_.width, cells_.height, kGuideChannels, y, width,
                                  [row](std::int32_t x, std::int32_t i, std::int32_t value) noexcept {
                                    row[x * kChannels + kGuideAt + i] = static_cast<std::uint8_t>(value);
                                  });
    for (std::int32_t x = 0; x < width; ++x) {
      std::uint8_t* const to = row + x * kChannels;
      to[0] = static_cast<std::uint8_t>((start[x] + 64) >> 7);
      const std::int32_t nearest = (start[x] + 128) >> 8;
      for (std::int32_t i = 0; i < 3; ++i) {
        const std::int32_t k = nearest - 1 + i;
        const bool there = k >= 0 && k < inputs_.used;
        const std::uint8_t* const plane =
            inputs_.half.data() + static_cast<std::size_t>(there ? k : 0) * plane_bytes;
        to[1 + i] = there ? half_count(plane, static_cast<std::size_t>(y * width + x)) : std::uint8_t{0};
      }
    }
  }
}

void Network::refine_output(int part, int parts) noexcept {
  const std::int32_t width = halves_.width;
  const std::int32_t last = 256 * (inputs_.used - 1);
  for (std::int32_t y = halves_.height * part / parts; y < halves_.height * (part + 1) / parts; ++y) {
    const std::uint8_t* const trust = confidence_4_ + y / 2 * cells_.width;
    for (std::int32_t x = 0; x < width; ++x) {
      const auto at = static_cast<std::size_t>(y * width + x);
      start_[at] = static_cast<std::uint16_t>(clamp_s32(start_[at] + change_[at], 0, last));
      confidence_[at] = trust[x / 2] > 0 ? trust[x / 2] : std::uint8_t{1};
    }
  }
}

// Where 3x3 cells span more than a border, the largest index of them. A cell beyond the edge is its neighbour
// again.
void Network::nearer_at_borders(int part, int parts) noexcept {
  const std::int32_t width = halves_.width;
  for (std::int32_t y = halves_.height * part / parts; y < halves_.height * (part + 1) / parts; ++y) {
    const std::uint16_t* const row = start_ + y * width;
    const std::uint16_t* const above = y > 0 ? row - width : row;
    const std::uint16_t* const below = y + 1 < halves_.height ? row + width : row;
    std::uint16_t* const to = index_q8_.data() + y * width;
    const auto column = [=](std::int32_t x) noexcept {
      return over(over({above[x], above[x]}, {row[x], row[x]}), {below[x], below[x]});
    };
    const auto cell = [=](std::int32_t left, std::int32_t x, std::int32_t right) noexcept {
      const Span span = over(over(column(left), column(x)), column(right));
      return span.most - span.least > kBorder_q8 ? span.most : row[x];
    };
    const std::int32_t last = width - 1;
    to[0] = cell(0, 0, last > 0 ? 1 : 0);
    for (std::int32_t x = 1; x < last; ++x) to[x] = cell(x - 1, x, x + 1);
    to[last] = cell(last > 0 ? last - 1 : 0, last, last);
  }
}

void Network::refine(WorkerPool& pool) noexcept {
  by_rows(pool, cells_.height, [this](std::int32_t first, std::int32_t rows) noexcept {
    guide_.relu(at_4_, guide_4_, first, rows);
  });
  refine_in_.fill_border(0);
  for (const Tensor& tensor : refine_) tensor.fill_border(0);
  in_parts(pool, [this](int part, int parts) noexcept { refine_input(part, parts); });
  const Tensor* from = &refine_in_;
  for (std::int32_t i = -1; i < facts_.dilation_count; ++i) {
    const ConvLayer& layer = i < 0 ? first_ : body_[i];
    const Tensor& to = from == &refine_[0] ? refine_[1] : refine_[0];
    by_rows(pool, halves_.height,
            [&](std::int32_t first, std::int32_t rows) noexcept { layer.relu(*from, to, first, rows); });
    from = &to;
  }
  show("refined", *from);
  in_parts(pool, [this, from](int part, int parts) noexcept {
    const std::int32_t first = halves_.height * part / parts;
    const std::int32_t end = halves_.height * (part + 1) / parts;
    last_.scores(*from, change_, 2, 2 * halves_.width, first, end - first);
    refine_output(part, parts);
  });
  in_parts(pool, [this](int part, int parts) noexcept { nearer_at_borders(part, parts); });
}

}  // namespace egofocus
