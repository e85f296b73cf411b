#include "pipeline/depth_decode.hpp"

namespace egofocus {
namespace {

constexpr std::int32_t kEdge_q8 = 2 * 256;

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
    for (std::int32_t x = 0; x < grid_.width_px; ++x) {
      const std::int32_t cell_x = x / 2;
      std::int32_t beside_x = (x & 1) ? cell_x + 1 : cell_x - 1;
      if (beside_x < 0 || beside_x >= width) beside_x = cell_x;
      const auto own_at = static_cast<std::size_t>(cell_y * width + cell_x);
      const std::size_t out = static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width_px) +
                              static_cast<std::size_t>(x);
      const std::uint8_t confidence = cells_.confidence[own_at];
      confidence_[out] = confidence;
      if (confidence == 0) {
        inverse_depth_[out] = 0;
        continue;
      }
      const std::int32_t own = index_q8_[own_at];
      const auto neighbour = [&](std::int32_t cx, std::int32_t cy) noexcept {
        const auto at = static_cast<std::size_t>(cy * width + cx);
        const std::int32_t value = index_q8_[at];
        const std::int32_t step = value > own ? value - own : own - value;
        return cells_.confidence[at] == 0 || step > kEdge_q8 ? own : value;
      };
      const std::int32_t sum = 9 * own + 3 * neighbour(beside_x, cell_y) + 3 * neighbour(cell_x, beside_y) +
                               neighbour(beside_x, beside_y);
      inverse_depth_[out] = static_cast<std::uint16_t>((sum + 8) >> 4);
    }
  }
}

}  // namespace egofocus
