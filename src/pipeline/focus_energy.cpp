#include "pipeline/focus_energy.hpp"

namespace egofocus {
namespace {

constexpr std::int32_t kCell = 4;

std::uint16_t saturated(std::uint32_t sum) noexcept {
  return static_cast<std::uint16_t>(sum < 65535 ? sum : 65535);
}

// Column sums of one row of pixels, added to those of the cell's earlier rows.
void add_row(const std::uint8_t* row, const std::uint8_t* above, const std::uint8_t* below,
             std::int32_t width, std::uint32_t* gx, std::uint32_t* gy, std::uint32_t* squares,
             std::uint32_t* counts) noexcept {
  for (std::int32_t x = 1; x + 1 < width; ++x) {
    const std::int32_t d = row[x + 1] - row[x - 1];
    gx[x] += static_cast<std::uint32_t>(d * d);
  }
  if (above != nullptr && below != nullptr) {
    for (std::int32_t x = 0; x < width; ++x) {
      const std::int32_t d = below[x] - above[x];
      gy[x] += static_cast<std::uint32_t>(d * d);
    }
  }
  for (std::int32_t x = 0; x < width; ++x) {
    const std::uint32_t n = row[x];
    counts[x] += n;
    squares[x] += n * n - n;
  }
}

// One box along rows, in place through `line`; the running sum is exact in modular arithmetic.
void box_row(std::uint32_t* row, std::int32_t width, std::int32_t reach, std::uint32_t* line) noexcept {
  std::uint32_t sum = 0;
  for (std::int32_t x = 0; x < reach && x < width; ++x) sum += row[x];
  for (std::int32_t x = 0; x < width; ++x) {
    if (x + reach < width) sum += row[x + reach];
    if (x - reach - 1 >= 0) sum -= row[x - reach - 1];
    line[x] = sum;
  }
  for (std::int32_t x = 0; x < width; ++x) row[x] = line[x];
}

// One box along columns.
void box_columns(const std::uint32_t* in, const EnergyGrid& grid, std::int32_t reach,
                 std::uint32_t* out) noexcept {
  const auto width = static_cast<std::size_t>(grid.width);
  for (std::int32_t y = 0; y < grid.height; ++y) {
    std::uint32_t* to = out + static_cast<std::size_t>(y) * width;
    for (std::size_t x = 0; x < width; ++x) to[x] = 0;
    const std::int32_t first = y - reach > 0 ? y - reach : 0;
    const std::int32_t last = y + reach < grid.height - 1 ? y + reach : grid.height - 1;
    for (std::int32_t v = first; v <= last; ++v) {
      const std::uint32_t* from = in + static_cast<std::size_t>(v) * width;
      for (std::size_t x = 0; x < width; ++x) to[x] += from[x];
    }
  }
}

}  // namespace

EnergyGrid energy_grid(std::int32_t width_px, std::int32_t height_px) noexcept {
  return {(width_px + kCell - 1) / kCell, (height_px + kCell - 1) / kCell};
}

void sum_cells(std::span<const std::uint8_t> plane, std::int32_t width_px, std::int32_t height_px,
               std::span<std::uint32_t> scratch, const CellSums& out) noexcept {
  const EnergyGrid grid = energy_grid(width_px, height_px);
  const auto width = static_cast<std::size_t>(width_px);
  std::uint32_t* gx = scratch.data();
  std::uint32_t* gy = gx + width;
  std::uint32_t* squares = gy + width;
  std::uint32_t* counts = squares + width;
  for (std::int32_t cell_y = 0; cell_y < grid.height; ++cell_y) {
    for (std::size_t i = 0; i < 4 * width; ++i) scratch[i] = 0;
    for (std::int32_t y = cell_y * kCell; y < (cell_y + 1) * kCell && y < height_px; ++y) {
      const std::uint8_t* row = plane.data() + static_cast<std::size_t>(y) * width;
      const bool inner = y > 0 && y + 1 < height_px;
      add_row(row, inner ? row - width : nullptr, inner ? row + width : nullptr, width_px, gx, gy, squares,
              counts);
    }
    const std::size_t at = static_cast<std::size_t>(cell_y) * static_cast<std::size_t>(grid.width);
    for (std::int32_t cell_x = 0; cell_x < grid.width; ++cell_x) {
      std::uint32_t sums[4] = {0, 0, 0, 0};
      for (std::int32_t x = cell_x * kCell; x < (cell_x + 1) * kCell && x < width_px; ++x) {
        sums[0] += gx[x];
        sums[1] += gy[x];
        sums[2] += squares[x];
        sums[3] += counts[x];
      }
      const std::size_t cell = at + static_cast<std::size_t>(cell_x);
      out.gradient_x[cell] = saturated(sums[0]);
      out.gradient_y[cell] = saturated(sums[1]);
      out.squares[cell] = saturated(sums[2]);
      out.counts[cell] = saturated(sums[3]);
    }
  }
}

void sum_support(std::span<const std::uint16_t> cells, const EnergyGrid& grid, std::int32_t side,
                 std::span<std::uint32_t> scratch, std::span<std::uint32_t> out) noexcept {
  for (std::size_t i = 0; i < grid.size(); ++i) out[i] = cells[i];
  const std::int32_t reach = side / 2;
  if (reach == 0) return;
  for (std::int32_t y = 0; y < grid.height; ++y) {
    std::uint32_t* row = out.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width);
    box_row(row, grid.width, reach, scratch.data());
    box_row(row, grid.width, reach, scratch.data());
  }
  box_columns(out.data(), grid, reach, scratch.data());
  box_columns(scratch.data(), grid, reach, out.data());
}

void halve_counts(std::span<const std::uint8_t> plane, std::int32_t width_px, std::int32_t height_px,
                  std::span<std::uint8_t> out) noexcept {
  const auto width = static_cast<std::size_t>(width_px);
  const std::size_t half_width = (width + 1) / 2;
  for (std::int32_t y = 0; y < height_px; y += 2) {
    const std::uint8_t* row = plane.data() + static_cast<std::size_t>(y) * width;
    const std::uint8_t* next = y + 1 < height_px ? row + width : nullptr;
    std::uint8_t* to = out.data() + static_cast<std::size_t>(y / 2) * half_width;
    for (std::size_t x = 0; x < width; x += 2) {
      const bool wide = x + 1 < width;
      std::uint32_t sum = row[x];
      if (wide) sum += row[x + 1];
      if (next != nullptr) sum += next[x];
      if (next != nullptr && wide) sum += next[x + 1];
      to[x / 2] = static_cast<std::uint8_t>(sum < 255 ? sum : 255);
    }
  }
}

}  // namespace egofocus
