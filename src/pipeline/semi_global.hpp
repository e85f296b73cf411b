// Semi-global smoothing of a cost volume along four paths (after Hirschmueller, "Stereo processing by
// semiglobal matching", equation 13), in int16:
//   L(p, k) = q(p, k) + min(L(p', k), L(p', k +- 1) + P1, min_i L(p', i) + P2) - min_i L(p', i),   sum over
//   paths
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "pipeline/focus_cost.hpp"

namespace egofocus {

class SemiGlobal {
 public:
  static constexpr std::int16_t kSmallStep = 20;   // P1: one hypothesis
  static constexpr std::int16_t kLargeStep = 120;  // P2: any jump
  static constexpr int kMaxParts = Warp::kMaxParts;

  SemiGlobal(CellGrid cells, std::int32_t hypotheses, int parts, Arena& arena) noexcept;

  /// Fewer hypotheses than the storage was made for. Thread: the tick, before the passes. RT: yes.
  void set_hypotheses(std::int32_t hypotheses) noexcept { hypotheses_ = hypotheses; }

  /// `penalty[cell * hypotheses + k]`, 0..255, small is good. Fills the sums of both horizontal paths for the
  /// rows of `part`, then (a second pass, after all parts of the first) adds both vertical ones for the
  /// columns of `part`. Sums are at most 4 * (255 + P2). Parts may run at once. RT: yes.
  void along_rows(std::span<const std::uint8_t> penalty, int part, int parts) noexcept;
  void along_columns(std::span<const std::uint8_t> penalty, int part, int parts) noexcept;

  /// [cell * hypotheses + k]
  [[nodiscard]] std::span<const std::int16_t> sums() const noexcept { return sums_; }

 private:
  struct State {
    std::span<std::int16_t> previous;  // [cells across the path][hypotheses + 2]: a guard on both sides
    std::span<std::int16_t> next;
    std::span<std::int16_t> smallest;
  };
  CellGrid cells_;
  std::int32_t hypotheses_;
  std::span<std::int16_t> sums_;
  State states_[kMaxParts];
};

}  // namespace egofocus
