#include "pipeline/depth_decode.hpp"

namespace egofocus {
namespace {

constexpr std::uint16_t kEdge_q8 = 2 * 256;

// Middle of n <= 25 values, the lower one of two; n >= 1. Insertion sort: n is small and mostly in order.
std::uint16_t middle(std::uint16_t* values, int n) noexcept {
  for (int i = 1; i < n; ++i) {
    const std::uint16_t v = values[i];
    int j = i;
    for (; j > 0 && values[j - 1] > v; --j) values[j] = values[j - 1];
    values[j] = v;
  }
  return values[(n - 1) / 2];
}

struct CellRow {
  const std::uint16_t* index_q8;
  const std::uint8_t* confidence;
};

// How far a neighbour is from the pixel's own cell: 0 where it counts as that. At most kEdge_q8: 16 bits
// hold what is made of it.
std::int16_t step_to(const CellRow& row, std::int32_t x, std::uint16_t own) noexcept {
  const std::uint16_t other = row.index_q8[x];
  const auto size = static_cast<std::uint16_t>(other > own ? other - own : own - other);
  const auto close = static_cast<std::uint16_t>(size <= kEdge_q8 ? 0xffff : 0);
  const auto known = static_cast<std::uint16_t>(row.confidence[x] != 0 ? 0xffff : 0);
  return static_cast<std::int16_t>((other - own) & close & known);
}

// The pixel of cell x that lies towards cell `towards`: (9 own + 3 b + 3 c + d + 8) / 16, as steps from own.
[[gnu::always_inline]] inline std::uint16_t pixel(const CellRow& own, const CellRow& beside, std::int32_t x,
                                                  std::int32_t towards) noexcept {
  const std::uint16_t index = own.index_q8[x];
  const auto steps = static_cast<std::int16_t>(
      3 * (step_to(own, towards, index) + step_to(beside, x, index)) + step_to(beside, towards, index) + 8);
  const auto known = static_cast<std::uint16_t>(own.confidence[x] != 0 ? 0xffff : 0);
  return static_cast<std::uint16_t>((index + (steps >> 4)) & known);
}

void enlarge_row(const CellRow& own, const CellRow& beside, std::int32_t width, std::int32_t width_px,
                 std::uint16_t* __restrict inverse_depth, std::uint8_t* __restrict confidence) noexcept {
  const std::int32_t last = width - 1;
  for (std::int32_t x = 1; x < last; ++x) {
    inverse_depth[2 * x] = pixel(own, beside, x, x - 1);
    inverse_depth[2 * x + 1] = pixel(own, beside, x, x + 1);
  }
  for (const std::int32_t x : {0, 2 * last}) {  // what is beyond the border counts as the own cell
    const std::int32_t left = x > 0 ? x / 2 - 1 : 0;
    const std::int32_t right = x / 2 < last ? x / 2 + 1 : last;
    inverse_depth[x] = pixel(own, beside, x / 2, left);
    if (x + 1 < width_px) inverse_depth[x + 1] = pixel(own, beside, x / 2, right);
  }
  for (std::int32_t x = 0; x < width_px / 2; ++x)
    confidence[2 * x] = confidence[2 * x + 1] = own.confidence[x];
  confidence[width_px - 1] = own.confidence[last];
}

}  // namespace

std::size_t metric_depth(const DepthFrame& frame, float far_m, std::span<float> out_m) noexcept {
  const std::size_t n = frame.inverse_depth.size() < out_m.size() ? frame.inverse_depth.size() : out_m.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double rho = frame.inverse_depth[i] * frame.inverse_depth_scale_per_m;
    float depth = rho * static_cast<double>(far_m) > 1.0 ? static_cast<float>(1.0 / rho) : far_m;
    if (frame.confidence[i] == 0) depth = 0;
    out_m[i] = depth;
  }
  return n;
}

DepthDecode::DepthDecode(const Intrinsics& grid, bool median, Arena& arena) noexcept : grid_(grid) {
  if (median) median_q8_ = arena.array<std::uint16_t>(cell_grid(grid).size());
}

void DepthDecode::run(const CellDepth& cells, WorkerPool& pool, std::span<std::uint16_t> inverse_depth,
                      std::span<std::uint8_t> confidence) noexcept {
  cells_ = cells;
  inverse_depth_ = inverse_depth;
  confidence_ = confidence;
  index_q8_ = cells.median ? std::span<const std::uint16_t>(median_q8_) : cells.index_q8;
  if (cells.median) {
    pool.run([](void* self, int part,
                int parts) noexcept { static_cast<DepthDecode*>(self)->median(part, parts); },
             this);
  }
  pool.run(
      [](void* self, int part, int parts) noexcept { static_cast<DepthDecode*>(self)->enlarge(part, parts); },
      this);
}

void DepthDecode::median(int part, int parts) noexcept {
  const std::int32_t width = cells_.cells.width;
  const std::int32_t height = cells_.cells.height;
  for (std::int32_t y = height * part / parts; y < height * (part + 1) / parts; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      std::uint16_t values[25];
      int n = 0;
      for (std::int32_t v = y > 2 ? y - 2 : 0; v <= y + 2 && v < height; ++v) {
        for (std::int32_t u = x > 2 ? x - 2 : 0; u <= x + 2 && u < width; ++u) {
          const auto at = static_cast<std::size_t>(v * width + u);
          if (cells_.confidence[at] != 0) values[n++] = cells_.index_q8[at];
        }
      }
      median_q8_[static_cast<std::size_t>(y * width + x)] = n > 0 ? middle(values, n) : std::uint16_t{0};
    }
  }
}

void DepthDecode::enlarge(int part, int parts) noexcept {
  const std::int32_t width = cells_.cells.width;
  const std::int32_t height = cells_.cells.height;
  for (std::int32_t y = grid_.height_px * part / parts; y < grid_.height_px * (part + 1) / parts; ++y) {
    const std::int32_t cell_y = y / 2;
    // Pixel centres lie a quarter cell from their cell's centre: even ones towards the previous cell, odd
    // ones the next.
    std::int32_t beside_y = (y & 1) ? cell_y + 1 : cell_y - 1;
    if (beside_y < 0 || beside_y >= height) beside_y = cell_y;
    const CellRow own{&index_q8_[static_cast<std::size_t>(cell_y * width)],
                      &cells_.confidence[static_cast<std::size_t>(cell_y * width)]};
    const CellRow beside{&index_q8_[static_cast<std::size_t>(beside_y * width)],
                         &cells_.confidence[static_cast<std::size_t>(beside_y * width)]};
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width_px);
    enlarge_row(own, beside, width, grid_.width_px, &inverse_depth_[at], &confidence_[at]);
  }
}

}  // namespace egofocus
