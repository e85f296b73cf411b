// The fixed front end of the focus-first network: how sharp one plane of warped events is, before anything
// learned. Exact integers, so that training and the runtime see the same numbers. METHOD, sections 3 and 8.
//
//   Gx(x, y) = I(x+1, y) - I(x-1, y),  Gy likewise; at the border, where a neighbour is missing, 0
//   cell sums over 4x4 pixels:  gradient_x = sum Gx^2,  gradient_y = sum Gy^2,
//                               squares = sum I (I - 1),  counts = sum I,  each saturating at 65535
//   support:  E_r = box_r * box_r * cell sums (two boxes of r x r cells, zero outside)
#pragma once

#include <cstdint>
#include <span>

namespace egofocus {

/// Cells of 4x4 pixels; what is left over at the right and at the bottom makes cells of its own.
struct EnergyGrid {
  std::int32_t width = 0;
  std::int32_t height = 0;
  [[nodiscard]] std::size_t size() const noexcept {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};
EnergyGrid energy_grid(std::int32_t width_px, std::int32_t height_px) noexcept;

/// Where the sums of one plane go: [height][width] of the energy grid, each.
struct CellSums {
  std::span<std::uint16_t> gradient_x;
  std::span<std::uint16_t> gradient_y;
  std::span<std::uint16_t> squares;
  std::span<std::uint16_t> counts;
};

/// `plane`: counts [height][width]. `scratch`: 4 * width values. Thread: any. RT: yes, O(pixels).
void sum_cells(std::span<const std::uint8_t> plane, std::int32_t width_px, std::int32_t height_px,
               std::span<std::uint32_t> scratch, const CellSums& out) noexcept;

/// first + second, cell by cell: what fits 16 bits goes to `first`, what is beyond stays in `second`. Says
/// whether anything is: hardly ever. Sizes are equal. Thread: any. RT: yes, O(cells).
bool gather(std::span<std::uint16_t> first, std::span<std::uint16_t> second) noexcept;

/// E_r of row `y` of maps [hypotheses][cells], each plane_stride after the one before; `second`, unless
/// nullptr, are other maps, each of which is added where adds_second says so. side: odd, 1..7 (1: a copy), so
/// that 2 * 65535 * side^4 fits. out: [hypotheses][padded], where padded is grid.width or more and a multiple
/// of 8; beyond the grid stands what its zeros give. line: 2 * (padded + 6) values of scratch. Thread: any.
/// RT: yes, O(hypotheses * width * side).
void support_row(const std::uint16_t* first, const std::uint16_t* second, std::span<const bool> adds_second,
                 std::int32_t hypotheses, std::size_t plane_stride, const EnergyGrid& grid, std::int32_t side,
                 std::int32_t y, std::span<std::uint32_t> line, std::int32_t padded,
                 std::uint32_t* out) noexcept;

/// Counts over cells of 2x2 pixels, saturating at 255: what the refinement gathers. out: [ceil(height / 2)]
/// [ceil(width / 2)]. Thread: any. RT: yes, O(pixels).
void halve_counts(std::span<const std::uint8_t> plane, std::int32_t width_px, std::int32_t height_px,
                  std::span<std::uint8_t> out) noexcept;

}  // namespace egofocus
