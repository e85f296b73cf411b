#include "pipeline/focus_energy.hpp"

namespace egofocus {
namespace {

constexpr std::int32_t kCell = 4;
constexpr std::int32_t kMostReach = 3;

std::uint16_t saturated(std::uint32_t sum) noexcept {
  return static_cast<std::uint16_t>(sum < 65535 ? sum : 65535);
}

// Squares of counts and of their differences fit 16 bits, where all vector units multiply.
std::uint16_t squared(std::int32_t difference) noexcept {
  const auto d = static_cast<std::uint16_t>(difference);
  return static_cast<std::uint16_t>(static_cast<std::uint32_t>(d) * d);  // exact: at most 255^2, modulo 2^16
}

// Column sums of one row of pixels, added to those of the cell's earlier rows.
void add_row(const std::uint8_t* row, const std::uint8_t* above, const std::uint8_t* below,
             std::int32_t width, std::uint32_t* gx, std::uint32_t* gy, std::uint32_t* squares,
             std::uint32_t* counts) noexcept {
  for (std::int32_t x = 1; x + 1 < width; ++x) gx[x] += squared(row[x + 1] - row[x - 1]);
  if (above != nullptr && below != nullptr) {
    for (std::int32_t x = 0; x < width; ++x) gy[x] += squared(below[x] - above[x]);
  }
  for (std::int32_t x = 0; x < width; ++x) squares[x] += static_cast<std::uint16_t>(squared(row[x]) - row[x]);
  for (std::int32_t x = 0; x < width; ++x) counts[x] += row[x];
}

// One box along a row; `in` and `out` have `reach` zeros on either side of what they point to.
void box_line(const std::uint32_t* in, std::int32_t width, std::int32_t reach, std::uint32_t* out) noexcept {
  switch (reach) {
    case 1:
      for (std::int32_t x = 0; x < width; ++x) out[x] = in[x - 1] + in[x] + in[x + 1];
      break;
    case 2:
      for (std::int32_t x = 0; x < width; ++x)
        out[x] = (in[x - 2] + in[x - 1]) + in[x] + (in[x + 1] + in[x + 2]);
      break;
    default:
      for (std::int32_t x = 0; x < width; ++x)
        out[x] = (in[x - 3] + in[x - 2]) + (in[x - 1] + in[x]) + (in[x + 1] + in[x + 2]) + in[x + 3];
      break;
  }
}

// Rows that a doubled box takes in around row y, and how often: as many times as both boxes meet in a row of
// the grid.
struct RowWeights {
  std::int32_t first = 0;
  std::int32_t count = 0;
  std::uint16_t weight[4 * kMostReach + 1] = {};
};
RowWeights row_weights(std::int32_t height, std::int32_t reach, std::int32_t y) noexcept {
  RowWeights out;
  out.first = y > 2 * reach ? y - 2 * reach : 0;
  const std::int32_t last = y + 2 * reach < height - 1 ? y + 2 * reach : height - 1;
  for (std::int32_t v = out.first; v <= last; ++v) {
    const std::int32_t from = (v > y ? v : y) - reach;
    const std::int32_t to = (v < y ? v : y) + reach;
    out.weight[out.count++] =
        static_cast<std::uint16_t>((to < height - 1 ? to : height - 1) - (from > 0 ? from : 0) + 1);
  }
  return out;
}

// kCells sums at once stay where vector units keep them. `first` and `second` are at the first row.
template <std::int32_t kCells>
void sum_rows(const std::uint16_t* first, const std::uint16_t* second, std::int32_t width,
              const RowWeights& rows, std::uint32_t* out) noexcept {
  std::uint32_t sum[kCells] = {};
  for (const std::uint16_t* cells : {first, second}) {
    if (cells == nullptr) continue;
    for (std::int32_t v = 0; v < rows.count; ++v, cells += width) {
      const std::uint16_t weight = rows.weight[v];
      for (std::int32_t x = 0; x < kCells; ++x) sum[x] += static_cast<std::uint32_t>(cells[x]) * weight;
    }
  }
  for (std::int32_t x = 0; x < kCells; ++x) out[x] = sum[x];
}

void sum_rows(const std::uint16_t* first, const std::uint16_t* second, std::int32_t width,
              const RowWeights& rows, std::uint32_t* out) noexcept {
  constexpr std::int32_t kBlock = 16;
  const std::int32_t block_end = width - kBlock;
  for (std::int32_t x = 0; x < width;) {
    const std::uint16_t* const other = second != nullptr ? second + x : nullptr;
    if (width < kBlock) {
      sum_rows<1>(first + x, other, width, rows, out + x);
      ++x;
    } else {
      sum_rows<kBlock>(first + x, other, width, rows, out + x);
      x = x < block_end && x + kBlock > block_end ? block_end : x + kBlock;  // the last one overlaps
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

void support_row(const std::uint16_t* first, const std::uint16_t* second, std::int32_t hypotheses,
                 const EnergyGrid& grid, std::int32_t side, std::int32_t y, std::span<std::uint32_t> line,
                 std::uint32_t* out) noexcept {
  const std::int32_t reach = side / 2;
  const std::int32_t width = grid.width;
  const auto stride = static_cast<std::size_t>(width);
  std::uint32_t* const columns = line.data() + kMostReach;
  std::uint32_t* const boxed = columns + width + 2 * kMostReach;
  for (std::uint32_t& v : line) v = 0;
  const RowWeights rows = row_weights(grid.height, reach, y);
  const std::size_t first_cell = static_cast<std::size_t>(rows.first) * stride;
  for (std::int32_t k = 0; k < hypotheses; ++k) {
    std::uint32_t* const to = out + static_cast<std::size_t>(k) * stride;
    std::uint32_t* const sum = reach == 0 ? to : columns;
    const std::size_t at = static_cast<std::size_t>(k) * grid.size() + first_cell;
    sum_rows(first + at, second != nullptr ? second + at : nullptr, width, rows, sum);
    if (reach == 0) continue;
    box_line(columns, width, reach, boxed);
    box_line(boxed, width, reach, to);
  }
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
