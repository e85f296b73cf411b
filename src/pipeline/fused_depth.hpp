// Depth of this tick and of those before it, fused cell by cell: where the world stands still each tick
// measures it anew, and a weighted mean of several measurements errs less than one. A filter with one weight
// a cell, in integers.
//
// A measurement's weight is 1 / S^2, S its spread in steps of the ladder (CellDepth::spread_q8). Against
// truth an index errs by about .8 S. Earlier weights fade evenly to nothing in CarryConfig::fuse_us.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "core/worker_pool.hpp"
#include "egofocus/config.hpp"
#include "pipeline/depth_reprojection.hpp"
#include "pipeline/focus.hpp"
#include "pipeline/motion_track.hpp"

namespace egofocus {

/// Thread: the tick's. RT: yes, but the constructor.
class FusedDepth {
 public:
  /// Takes 9 bytes a cell from the arena. Precondition: config.fuse_us > 0.
  FusedDepth(const CarryConfig& config, const Intrinsics& grid, Arena& arena) noexcept;

  /// Whether earlier depth can still have weight at this time; older is dropped.
  bool kept_at(std::int64_t t_us) noexcept;
  /// Earlier depth is as seen from where the camera was at this time. Precondition: kept_at() was true.
  [[nodiscard]] std::int64_t seen_us() const noexcept { return seen_us_; }

  /// Where a cell's point lay at seen_us(), what was known there, moved to here: fused with what is measured
  /// where they differ by at most 3 sigma; the measurement alone where they differ more (something moved, or
  /// came into view) or nothing was known. `since`: takes points from the camera at seen_us() to the one at
  /// t_us; nullptr: nothing earlier is used. step_per_m: of the cells' index. A cell without an estimate
  /// stays so, and is forgotten. What was known may be nearer than this tick's ladder, and the result with
  /// it; its confidence is index / (index + S). The result views this object's memory until the next call.
  /// Precondition: cells.spread_q8 is known.
  CellDepth fuse(const CellDepth& cells, double step_per_m, std::int64_t t_us, const MotionKnot* since,
                 WorkerPool& pool) noexcept;

 private:
  struct Cells {
    std::span<std::uint16_t> index_q8;
    std::span<std::uint16_t> weight;  // 1024 / S^2, at least 1; 0: no estimate
  };
  struct Earlier {
    Reprojection back;             // from here to the camera at seen_us()
    std::uint64_t index_q16 = 0;   // earlier index -> index of this tick's ladder
    std::uint64_t weight_q16 = 0;  // earlier weight -> weight now
  };
  struct Estimate {
    std::uint32_t index_q8 = 0;
    std::uint32_t weight = 0;
  };
  void fuse_rows(const CellDepth& measured, const Earlier* earlier, std::int32_t first,
                 std::int32_t rows) noexcept;
  [[nodiscard]] Estimate look_back(const Earlier& earlier, std::int32_t x, std::int32_t y,
                                   std::uint32_t index_q8) const noexcept;
  [[nodiscard]] Estimate found_at(const Earlier& earlier, const Landing& there,
                                  std::uint32_t looked_up_q8) const noexcept;

  std::int64_t fuse_us_;
  double max_travel_;
  Intrinsics grid_;  // of the cells
  Cells now_;
  Cells before_;
  std::span<std::uint8_t> confidence_;
  double step_per_m_ = 0;
  std::int64_t seen_us_ = 0;
  bool kept_ = false;
};

}  // namespace egofocus
