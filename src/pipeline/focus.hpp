// The classical backend: focus cost of every hypothesis, optional semi-global smoothing, best hypothesis with
// a sub-bin fit, confidence from how far the best stands out.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "core/worker_pool.hpp"
#include "egofocus/config.hpp"
#include "pipeline/focus_cost.hpp"
#include "pipeline/semi_global.hpp"
#include "pipeline/warp.hpp"

namespace egofocus {

/// What a backend hands to depth_decode: one value per cell.
struct CellDepth {
  CellGrid cells;
  std::span<const std::uint16_t> index_q8;   ///< hypothesis at 1/256 bin
  std::span<const std::uint8_t> confidence;  ///< 0 = no estimate
  bool median = true;                        ///< depth_decode takes the median over neighbours first
  /// The index's spread in 1/256 bin, for each 2x2 of the cells; empty: not known.
  std::span<const std::uint16_t> spread_q8 = {};
};

class Focus {
 public:
  Focus(const Config& config, int parts, Arena& arena) noexcept;

  /// Runs on the pool; the result is valid until the next call. Thread: the tick. RT: yes.
  /// `baseline_m` is the camera's centre at the window's begin, seen at its end: it says how much parallax
  /// there really is at each cell.
  CellDepth run(const Warp& warp, const HypothesisLadder& ladder, const double (&baseline_m)[3],
                WorkerPool& pool) noexcept;

 private:
  struct alignas(kCacheLine) PartSum {
    std::uint64_t contrast = 0;
  };
  void costs(int part, int parts) noexcept;
  void contrast(int part, int parts) noexcept;
  void penalties(int part, int parts) noexcept;
  void decide(int part, int parts) noexcept;
  [[nodiscard]] std::uint32_t full_parallax_q4(std::size_t cell) const noexcept;
  template <void (Focus::*kStep)(int, int) noexcept>
  void run_step(WorkerPool& pool) noexcept;

  FocusConfig config_;
  Intrinsics grid_;
  CellGrid cells_;
  std::int32_t hypotheses_;
  std::uint32_t min_density_q8_;
  FocusCostPlane plane_cost_;
  SemiGlobal smoothing_;
  std::span<std::uint16_t> cost_;       // [k][cell]
  std::span<std::uint16_t> density_;    // [k][cell], 1/256 event per pixel
  std::span<std::uint8_t> penalty_;     // [cell][k]
  std::span<std::uint16_t> best_cost_;  // [cell]
  std::span<std::uint16_t> index_q8_;
  std::span<std::uint8_t> confidence_;
  PartSum sums_[Warp::kMaxParts];
  std::uint32_t penalty_scale_q16_ = 0;
  const Warp* warp_ = nullptr;
  std::int32_t used_ = 0;                // hypotheses of the tick, <= hypotheses_
  double full_baseline_[3] = {0, 0, 0};  // baseline times the last hypothesis: without unit
};

}  // namespace egofocus
