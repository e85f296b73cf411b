#include "pipeline/focus_energy.hpp"

namespace egofocus {
namespace {

constexpr std::int32_t kCell = 4;
constexpr std::int32_t kMostReach = 3;

std::uint16_t saturated(std::uint32_t sum) noexcept {
  return static_cast<std::uint16_t>(sum < 65535 ? sum : 65535);
}

// step.operator()<n>(x) for n values from x on: whole blocks where the width has one, and the last of them
// overlaps the one before it.
template <std::int32_t kBlock, typename Step>
void in_blocks(std::int32_t width, const Step& step) noexcept {
  if (width < kBlock) {
    for (std::int32_t x = 0; x < width; ++x) step.template operator()<1>(x);
    return;
  }
  for (std::int32_t x = 0; x < width; x += kBlock)
    step.template operator()<kBlock>(x < width - kBlock ? x : width - kBlock);
}

// Sums over rows of a strip, a column each.
template <typename Sum>
struct ColumnSums {
  Sum* gx;
  Sum* gy;
  Sum* all_squares;  // of counts: not yet less the counts
  Sum* counts;
};

// A difference's square fits 16 bits, where all vector units multiply.
template <typename Sum>
Sum plus_square(Sum sum, std::int32_t difference) noexcept {
  const auto d = static_cast<std::uint16_t>(difference);
  return static_cast<Sum>(sum + static_cast<std::uint16_t>(static_cast<std::uint32_t>(d) * d));
}

// Rows 1 .. kRows are summed; rows 0 and kRows + 1 are their neighbours.
template <std::int32_t kRows, typename Sum>
void sum_columns(const std::uint8_t* const (&rows)[kCell + 2], std::int32_t width,
                 const ColumnSums<Sum>& out) noexcept {
  Sum* __restrict const gx = out.gx;
  Sum* __restrict const gy = out.gy;
  Sum* __restrict const all_squares = out.all_squares;
  Sum* __restrict const counts = out.counts;
  for (std::int32_t x = 1; x + 1 < width; ++x) {
    Sum sum = 0;
    for (std::int32_t i = 1; i <= kRows; ++i) sum = plus_square(sum, rows[i][x + 1] - rows[i][x - 1]);
    gx[x] = sum;
  }
  gx[0] = 0;
  gx[width - 1] = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    Sum sum = 0;
    for (std::int32_t i = 1; i <= kRows; ++i) sum = plus_square(sum, rows[i + 1][x] - rows[i - 1][x]);
    gy[x] = sum;
  }
  for (std::int32_t x = 0; x < width; ++x) {
    Sum squares = 0;
    Sum count = 0;
    for (std::int32_t i = 1; i <= kRows; ++i) {
      squares = plus_square(squares, rows[i][x]);
      count = static_cast<Sum>(count + rows[i][x]);
    }
    all_squares[x] = squares;
    counts[x] = count;
  }
}

// Sums of four columns, the last of what there is.
template <typename Sum>
void fold_columns(const Sum* columns, std::int32_t width, const std::uint16_t* less,
                  std::uint16_t* __restrict cells) noexcept {
  const std::int32_t whole = width / kCell;
  for (std::int32_t cell = 0; cell < whole; ++cell) {
    const Sum* const c = columns + cell * kCell;
    const std::uint32_t sum = (std::uint32_t{c[0]} + c[1]) + (std::uint32_t{c[2]} + c[3]);
    cells[cell] = saturated(less != nullptr ? sum - less[cell] : sum);
  }
  if (whole * kCell == width) return;
  std::uint32_t sum = 0;
  for (std::int32_t x = whole * kCell; x < width; ++x) sum += columns[x];
  cells[whole] = saturated(less != nullptr ? sum - less[whole] : sum);
}

// One row of cells. counts: at most 4080, they never saturate.
template <std::int32_t kRows, typename Sum>
void sum_strip(const std::uint8_t* const (&rows)[kCell + 2], std::int32_t width, Sum* scratch,
               const CellSums& out, std::size_t at) noexcept {
  const ColumnSums<Sum> columns{scratch, scratch + width, scratch + 2 * width, scratch + 3 * width};
  sum_columns<kRows>(rows, width, columns);
  std::uint16_t* const counts = &out.counts[at];
  fold_columns(columns.gx, width, nullptr, &out.gradient_x[at]);
  fold_columns(columns.gy, width, nullptr, &out.gradient_y[at]);
  fold_columns(columns.counts, width, nullptr, counts);
  fold_columns(columns.all_squares, width, counts, &out.squares[at]);
}

// No count above 127: four squares fit 16 bits.
bool all_small(const std::uint8_t* const (&rows)[kCell + 2], std::int32_t width) noexcept {
  std::uint8_t bits = 0;
  for (std::int32_t x = 0; x < width; ++x)
    bits |= static_cast<std::uint8_t>((rows[0][x] | rows[1][x] | rows[2][x]) |
                                      (rows[3][x] | rows[4][x] | rows[5][x]));
  return bits < 128;
}

// Rows y - 2 reach .. y + 2 reach, and how often a doubled box takes each in: as many times as both boxes
// meet in a row of the grid. One beyond the grid has no weight, and another's cells.
template <std::int32_t kReach>
struct RowWeights {
  static constexpr std::int32_t kRows = 4 * kReach + 1;
  RowWeights(const EnergyGrid& grid, std::int32_t y) noexcept {
    for (std::int32_t i = 0; i < kRows; ++i) {
      const std::int32_t v = y - 2 * kReach + i;
      const bool there = v >= 0 && v < grid.height;
      const std::int32_t from = (v > y ? v : y) - kReach;
      const std::int32_t to = (v < y ? v : y) + kReach;
      const std::int32_t met = (to < grid.height - 1 ? to : grid.height - 1) - (from > 0 ? from : 0) + 1;
      at_bytes[i] = std::ptrdiff_t{there ? v : y} * grid.width * 2;
      weight[i] = static_cast<std::uint16_t>(there ? met : 0);
    }
  }
  std::ptrdiff_t at_bytes[kRows];  // of the row's first cell; in bytes, no address takes a shift
  std::uint16_t weight[kRows];
};

template <std::int32_t kReach>
void weigh_rows(const std::uint16_t* plane, const RowWeights<kReach>& rows, std::int32_t width,
                std::uint32_t* __restrict out) noexcept {
  if constexpr (kReach == 0) {
    const std::uint16_t* const row = plane + rows.at_bytes[0] / 2;
    for (std::int32_t x = 0; x < width; ++x) out[x] = row[x];
    return;
  }
  in_blocks<16>(width, [&]<std::int32_t kCells>(std::int32_t x) noexcept {
    constexpr std::int32_t kRows = RowWeights<kReach>::kRows;
    const std::uint16_t* row[kRows];
    for (std::int32_t v = 0; v < kRows; ++v)
      row[v] = reinterpret_cast<const std::uint16_t*>(reinterpret_cast<const std::byte*>(plane + x) +
                                                      rows.at_bytes[v]);
    for (std::int32_t i = 0; i < kCells; ++i) {
      std::uint32_t sum = 0;
      for (std::int32_t v = 0; v < kRows; ++v) sum += std::uint32_t{row[v][i]} * rows.weight[v];
      out[x + i] = sum;
    }
  });
}

// One box along a row of whole eights; `in` has kReach zeros on either side of what it points to.
template <std::int32_t kReach>
void box_line(const std::uint32_t* in, std::int32_t padded, std::uint32_t* __restrict out) noexcept {
  const std::int32_t end = padded / 8 * 8;  // a compiler sees that there is no remainder
  for (std::int32_t x = 0; x < end; ++x) {
    std::uint32_t sum = in[x];
    for (std::int32_t t = 1; t <= kReach; ++t) sum += in[x - t] + in[x + t];
    out[x] = sum;
  }
}

template <std::int32_t kReach>
void support(const std::uint16_t* first, const std::uint16_t* second, std::span<const bool> adds_second,
             std::int32_t hypotheses, std::size_t plane_stride, const EnergyGrid& grid, std::int32_t y,
             std::span<std::uint32_t> line, std::int32_t padded, std::uint32_t* out) noexcept {
  std::uint32_t* const columns = line.data() + kMostReach;
  std::uint32_t* const boxed = columns + padded + 2 * kMostReach;
  for (std::uint32_t& v : line) v = 0;
  const RowWeights<kReach> rows(grid, y);
  for (std::int32_t k = 0; k < hypotheses; ++k) {
    const std::size_t plane = static_cast<std::size_t>(k) * plane_stride;
    std::uint32_t* const to = out + static_cast<std::size_t>(k) * static_cast<std::size_t>(padded);
    std::uint32_t* const sum = kReach == 0 ? to : columns;
    weigh_rows(first + plane, rows, grid.width, sum);
    if (second != nullptr && adds_second[static_cast<std::size_t>(k)]) {
      weigh_rows(second + plane, rows, grid.width, boxed);
      for (std::int32_t x = 0; x < grid.width; ++x) sum[x] += boxed[x];
    }
    std::uint32_t* const beyond = kReach == 0 ? to : boxed;
    if (kReach > 0) box_line<kReach>(columns, padded, boxed);
    for (std::int32_t x = grid.width; x < padded; ++x) beyond[x] = 0;
    if (kReach > 0) box_line<kReach>(boxed, padded, to);
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
  const auto cells = static_cast<std::size_t>(grid.width);
  for (std::int32_t cell_y = 0; cell_y < grid.height; ++cell_y) {
    const std::int32_t first = cell_y * kCell;
    const std::int32_t rows_left = height_px - first;
    // Beyond the border the other neighbour stands in for the missing one: no difference.
    const std::uint8_t* rows[kCell + 2];
    for (std::int32_t i = 0; i < kCell + 2; ++i) {
      std::int32_t y = first + i - 1;
      if (y < 0) y = height_px > 1 ? 1 : 0;
      if (y >= height_px) y = height_px > 1 ? height_px - 2 : 0;
      rows[i] = plane.data() + static_cast<std::size_t>(y) * width;
    }
    const std::size_t at = static_cast<std::size_t>(cell_y) * cells;
    switch (rows_left) {
      case 1:
        sum_strip<1>(rows, width_px, scratch.data(), out, at);
        break;
      case 2:
        sum_strip<2>(rows, width_px, scratch.data(), out, at);
        break;
      case 3:
        sum_strip<3>(rows, width_px, scratch.data(), out, at);
        break;
      default:
        if (all_small(rows, width_px)) {
          sum_strip<4>(rows, width_px, reinterpret_cast<std::uint16_t*>(scratch.data()), out, at);
        } else {
          sum_strip<4>(rows, width_px, scratch.data(), out, at);
        }
        break;
    }
  }
}

bool gather(std::span<std::uint16_t> first, std::span<std::uint16_t> second) noexcept {
  std::uint16_t* __restrict const to = first.data();
  std::uint16_t* __restrict const rest = second.data();
  std::uint16_t any = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::uint16_t sum = saturated(std::uint32_t{to[i]} + rest[i]);
    rest[i] = static_cast<std::uint16_t>(to[i] + rest[i] - sum);
    to[i] = sum;
    any |= rest[i];
  }
  return any != 0;
}

void support_row(const std::uint16_t* first, const std::uint16_t* second, std::span<const bool> adds_second,
                 std::int32_t hypotheses, std::size_t plane_stride, const EnergyGrid& grid, std::int32_t side,
                 std::int32_t y, std::span<std::uint32_t> line, std::int32_t padded,
                 std::uint32_t* out) noexcept {
  switch (side) {
    case 1:
      return support<0>(first, second, adds_second, hypotheses, plane_stride, grid, y, line, padded, out);
    case 3:
      return support<1>(first, second, adds_second, hypotheses, plane_stride, grid, y, line, padded, out);
    case 5:
      return support<2>(first, second, adds_second, hypotheses, plane_stride, grid, y, line, padded, out);
    default:
      return support<3>(first, second, adds_second, hypotheses, plane_stride, grid, y, line, padded, out);
  }
}

void halve_counts(std::span<const std::uint8_t> plane, std::int32_t width_px, std::int32_t height_px,
                  std::span<std::uint8_t> out) noexcept {
  const auto width = static_cast<std::size_t>(width_px);
  const std::size_t whole = width / 2;
  const std::size_t half_width = (width + 1) / 2;
  const auto capped = [](std::uint32_t sum) noexcept {
    return static_cast<std::uint8_t>(sum < 255 ? sum : 255);
  };
  for (std::int32_t y = 0; y < height_px; y += 2) {
    const std::uint8_t* const row = plane.data() + static_cast<std::size_t>(y) * width;
    const bool both = y + 1 < height_px;
    const std::uint8_t* const next = both ? row + width : row;
    std::uint8_t* __restrict const to = out.data() + static_cast<std::size_t>(y / 2) * half_width;
    const std::uint16_t mask = both ? 0xffff : 0;
    for (std::size_t x = 0; x < whole; ++x) {
      const auto below = static_cast<std::uint16_t>((next[2 * x] + next[2 * x + 1]) & mask);
      const auto sum = static_cast<std::uint16_t>(row[2 * x] + row[2 * x + 1] + below);
      to[x] = capped(sum);
    }
    if (whole < half_width) to[whole] = capped(row[width - 1] + (both ? std::uint32_t{next[width - 1]} : 0u));
  }
}

}  // namespace egofocus
