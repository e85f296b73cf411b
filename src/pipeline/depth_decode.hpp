// Cells to pixels: median, bilinear up-sampling in integers, and the frame's arrays.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "core/worker_pool.hpp"
#include "egofocus/types.hpp"
#include "pipeline/focus.hpp"

namespace egofocus {

class DepthDecode {
 public:
  /// `median`: whether cells will ever ask for it.
  DepthDecode(const Intrinsics& grid, bool median, Arena& arena) noexcept;

  /// index_q8 of each cell -> 5x5 median over the cells that have an estimate, if cells.median -> each pixel
  /// between its four nearest cell centres (weights 9 3 3 1 of 16, half up). A neighbour without an estimate,
  /// or further than two hypotheses away, counts as the pixel's own cell: depth edges stay edges. Confidence
  /// is that of the pixel's own cell. inverse_depth and confidence: [height * width]; 0 where there is no
  /// estimate. Thread: the tick. RT: yes.
  void run(const CellDepth& cells, WorkerPool& pool, std::span<std::uint16_t> inverse_depth,
           std::span<std::uint8_t> confidence) noexcept;

 private:
  void median(int part, int parts) noexcept;
  void enlarge(int part, int parts) noexcept;

  Intrinsics grid_;
  std::span<std::uint16_t> median_q8_;       // [cells]
  std::span<const std::uint16_t> index_q8_;  // median_q8_ or the backend's own
  CellDepth cells_;
  std::span<std::uint16_t> inverse_depth_;
  std::span<std::uint8_t> confidence_;
};

}  // namespace egofocus
