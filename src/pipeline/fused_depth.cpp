#include "pipeline/fused_depth.hpp"

#include "core/check.hpp"
#include "core/elementary.hpp"
#include "pipeline/fixed_point.hpp"
#include "pipeline/in_parts.hpp"

namespace egofocus {
namespace {

constexpr std::uint32_t kUnitWeight = 1024;              // of a spread of one step
constexpr std::uint32_t kMostWeight = 20 * kUnitWeight;  // so that what is seen now always counts
constexpr std::uint32_t kLeastSpread_q8 = 154;           // 0.6 steps
constexpr std::uint32_t kMostSpread_q8 = 32 * 256;
constexpr std::int64_t kMostIndex = 65535;
constexpr std::uint32_t kSure_q8 = 256;  // where the first look is this close, a second finds the same

Intrinsics of_cells(const Intrinsics& grid) noexcept {
  const CellGrid cells = cell_grid(grid);
  return {cells.width,    cells.height,           grid.fx_px / 2,
          grid.fy_px / 2, (grid.cx_px - 0.5) / 2, (grid.cy_px - 0.5) / 2};
}

std::uint32_t weight_of(std::uint32_t spread_q8) noexcept {
  if (spread_q8 < kLeastSpread_q8) spread_q8 = kLeastSpread_q8;
  if (spread_q8 > kMostSpread_q8) spread_q8 = kMostSpread_q8;
  return (kUnitWeight << 16) / (spread_q8 * spread_q8);
}

/// As the network's: index / (index + spread). At least 1: there is an estimate.
std::uint8_t confidence_of(std::uint32_t index_q8, std::uint32_t weight) noexcept {
  const std::uint32_t spread_q8 = floor_square_root_u32((kUnitWeight << 16) / weight);
  const std::uint32_t confidence = 255 * index_q8 / (index_q8 + spread_q8);
  return static_cast<std::uint8_t>(confidence > 0 ? confidence : 1u);
}

/// Further apart than 3 sigma: d^2 > 9 (1 / w + 1 / v).
bool differ(std::int64_t apart_q8, std::uint64_t w, std::uint64_t v) noexcept {
  const auto square = static_cast<std::uint64_t>(apart_q8 * apart_q8);
  return square * w * v > ((std::uint64_t{9} * kUnitWeight) << 16) * (w + v);
}

MotionKnot inverse(const MotionKnot& motion) noexcept {
  MotionKnot out;
  for (int row = 0; row < 3; ++row) {
    double shift = 0;
    for (int column = 0; column < 3; ++column) {
      out.rotation[3 * row + column] = motion.rotation[3 * column + row];
      shift -= motion.rotation[3 * column + row] * motion.centre_m[column];
    }
    out.centre_m[row] = shift;
  }
  return out;
}

std::uint64_t ratio_q16(double ratio) noexcept {
  return static_cast<std::uint64_t>(floor_of((ratio < 65535.0 ? ratio : 65535.0) * 65536 + 0.5));
}

}  // namespace

FusedDepth::FusedDepth(const CarryConfig& config, const Intrinsics& grid, Arena& arena) noexcept
    : fuse_us_(config.fuse_us), max_travel_(config.max_travel), grid_(of_cells(grid)) {
  const std::size_t cells = cell_grid(grid).size();
  for (Cells* map : {&now_, &before_}) {
    map->index_q8 = arena.array<std::uint16_t>(cells);
    map->weight = arena.array<std::uint16_t>(cells);
  }
  confidence_ = arena.array<std::uint8_t>(cells);
}

bool FusedDepth::kept_at(std::int64_t t_us) noexcept {
  kept_ = kept_ && t_us - seen_us_ < fuse_us_;
  return kept_;
}

CellDepth FusedDepth::fuse(const CellDepth& cells, double step_per_m, std::int64_t t_us,
                           const MotionKnot* since, WorkerPool& pool) noexcept {
  EGOFOCUS_CHECK(!cells.median && cells.index_q8.size() == now_.index_q8.size() && !cells.spread_q8.empty());
  const Cells swap = before_;
  before_ = now_;
  now_ = swap;
  Earlier earlier;
  const bool looks_back = since != nullptr && kept_at(t_us);
  if (looks_back) {
    const double steps = step_per_m_ / step_per_m;
    const double fade = 1.0 - static_cast<double>(t_us - seen_us_) / static_cast<double>(fuse_us_);
    earlier.back = reprojection(inverse(*since), grid_, step_per_m / 256, max_travel_);
    earlier.index_q16 = ratio_q16(steps);
    earlier.weight_q16 = ratio_q16(fade / (steps * steps));
  }
  by_rows(pool, grid_.height_px, [&](std::int32_t first, std::int32_t rows) noexcept {
    fuse_rows(cells, looks_back ? &earlier : nullptr, first, rows);
  });
  step_per_m_ = step_per_m;
  seen_us_ = t_us;
  kept_ = true;
  CellDepth out = cells;
  out.index_q8 = now_.index_q8;
  out.confidence = confidence_;
  return out;
}

void FusedDepth::fuse_rows(const CellDepth& measured, const Earlier* earlier, std::int32_t first,
                           std::int32_t rows) noexcept {
  auto at = static_cast<std::size_t>(first) * static_cast<std::size_t>(grid_.width_px);
  for (std::int32_t y = first; y < first + rows; ++y) {
    const std::uint16_t* const spread =
        &measured.spread_q8[static_cast<std::size_t>(y / 2 * ((grid_.width_px + 1) / 2))];
    for (std::int32_t x = 0; x < grid_.width_px; ++x, ++at) {
      std::uint8_t confidence = measured.confidence[at];
      Estimate cell;
      cell.index_q8 = measured.index_q8[at];
      if (confidence != 0) {
        cell.weight = weight_of(spread[x / 2]);
        if (earlier != nullptr) {
          const Estimate known = look_back(*earlier, x, y, cell.index_q8);
          const std::int64_t apart_q8 = std::int64_t{known.index_q8} - cell.index_q8;
          if (known.weight != 0 && !differ(apart_q8, cell.weight, known.weight)) {
            const std::int64_t sum = std::int64_t{cell.weight} + known.weight;
            const std::int64_t fused = cell.index_q8 * sum + apart_q8 * known.weight + sum / 2;
            cell.index_q8 = static_cast<std::uint32_t>(fused / sum);
            cell.weight = static_cast<std::uint32_t>(sum < kMostWeight ? sum : kMostWeight);
            confidence = confidence_of(cell.index_q8, cell.weight);
          }
        }
      }
      now_.index_q8[at] = static_cast<std::uint16_t>(cell.index_q8);
      now_.weight[at] = static_cast<std::uint16_t>(cell.weight);
      confidence_[at] = confidence;
    }
  }
}

// Which point of the earlier map it was depends on its depth. The measured one tells; where the earlier map
// says otherwise, a second look with that one.
FusedDepth::Estimate FusedDepth::look_back(const Earlier& earlier, std::int32_t x, std::int32_t y,
                                           std::uint32_t index_q8) const noexcept {
  Estimate known;
  std::uint32_t depth = index_q8;
  for (int look = 0; look < 2; ++look) {
    Landing there;
    if (!land(earlier.back, grid_, x, y, static_cast<std::uint16_t>(depth), there)) return {};
    known = found_at(earlier, there, depth);
    if (known.weight == 0) return {};
    const std::uint32_t change = known.index_q8 > depth ? known.index_q8 - depth : depth - known.index_q8;
    if (change < kSure_q8) break;
    depth = known.index_q8;
  }
  return known;
}

// Of depth i here, a point has i / n_2(i) there: i = earlier n_2(i), of which two steps from the i that was
// looked up are enough.
FusedDepth::Estimate FusedDepth::found_at(const Earlier& earlier, const Landing& there,
                                          std::uint32_t looked_up_q8) const noexcept {
  const std::int32_t u = (there.u_q16 + 32768) >> 16;
  const std::int32_t v = (there.v_q16 + 32768) >> 16;
  if (u < 0 || v < 0 || u >= grid_.width_px || v >= grid_.height_px) return {};
  const auto at =
      static_cast<std::size_t>(v) * static_cast<std::size_t>(grid_.width_px) + static_cast<std::size_t>(u);
  if (before_.weight[at] == 0) return {};
  const auto rescaled = static_cast<std::int64_t>((before_.index_q8[at] * earlier.index_q16) >> 16);
  if (rescaled > kMostIndex) return {};  // nearer than this ladder can say
  std::int64_t index = looked_up_q8;
  for (int step = 0; step < 2; ++step) {
    const std::int64_t ratio_q32 = there.depth_ratio_q32 + (index - looked_up_q8) * earlier.back.shift_q32[2];
    index = (rescaled * ratio_q32 + (std::int64_t{1} << 31)) >> 32;
    if (index < 0 || index > kMostIndex) return {};
  }
  std::uint64_t weight = (before_.weight[at] * earlier.weight_q16) >> 16;
  if (weight < 1) weight = 1;
  if (weight > kMostWeight) weight = kMostWeight;
  return {static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(weight)};
}

}  // namespace egofocus
