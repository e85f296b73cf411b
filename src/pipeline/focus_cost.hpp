// How sharply one image of warped events is in focus, per cell of 2x2 pixels. All integers.
//
//   A = support sum of a numerator g, S = support sum of the counts I, n = weight of the support
//   C = 256 * max(0, A - n J(S / n)) / (S + n / 20)
//
// J is the numerator's mean under evenly spread (Poisson) events of the same density: without it dense blur
// would win over sparse sharpness. Dividing by S makes cells with few and with many events alike; n / 20
// keeps noise down.
//   gradient  g = (I(x+1) - I(x-1))^2 + (I(y+1) - I(y-1))^2               J = 0 (neighbours are independent
//   noise) variance  g = 4 I (I - 1)                                             J = 4 l^2            (l = S
//   / n) sosa      g = 256 (exp(-d I) - 1 + (1 - exp(-d)) I), d = 0.4          J = the same under Poisson(l)
//   soe       g = 16 (exp(d I) - 1 - (exp(d) - 1) I), d = 0.1             J = the same under Poisson(l)
//   sti       g = I T^2 / 64, T = mean time of the pixel's events, -127..127; in focus g is SMALL: A and J
//   change sides,
//             J = 84 (1 - exp(-l))
// The linear parts in sosa and soe leave g = 0 for 0 and 1 events: only what piles up counts. Beyond 60
// events soe's exponential goes on along its tangent, or it would not fit 32 bits.
// Source: the four published costs (arXiv 2412.19067, ablation; Stoffregen and Kleeman, "Event cameras,
// contrast maximization and reward functions", for SoSA and SoE), the normalisation is ours.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "egofocus/config.hpp"
#include "egofocus/status.hpp"
#include "pipeline/warp.hpp"

namespace egofocus {

/// Cells of 2x2 pixels; an odd last row or column makes a cell of its own.
struct CellGrid {
  std::int32_t width = 0;
  std::int32_t height = 0;
  [[nodiscard]] std::size_t size() const noexcept {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};
CellGrid cell_grid(const Intrinsics& grid) noexcept;

class FocusCostPlane {
 public:
  static Status check(const FocusConfig& config) noexcept;

  /// Takes the scratch planes of `parts` parts and the tables from the arena.
  FocusCostPlane(const FocusConfig& config, const Intrinsics& grid, int parts, Arena& arena) noexcept;

  /// Cost of hypothesis k for every cell into cost_out[cells], and the support's event density into
  /// density_out[cells] in 1/256 event per pixel. Different parts may run at once. RT: yes.
  void compute(const Warp& warp, std::int32_t k, int part, std::span<std::uint16_t> cost_out,
               std::span<std::uint16_t> density_out) noexcept;

 private:
  static constexpr std::int32_t kMaxParts = Warp::kMaxParts;
  struct Scratch {
    std::span<std::uint32_t> numerator;  // [cells]
    std::span<std::uint32_t> counts;     // [cells]
    std::span<std::uint32_t> swap;       // [cells]
    std::span<std::uint32_t> row;        // [cell width], column sums
    std::span<std::uint32_t> times;      // sti: [pixels], sum of times << 12 | number of events
  };

  void gather_gradient(std::span<const std::uint8_t> plane, Scratch& s) const noexcept;
  void gather_table(std::span<const std::uint8_t> plane, Scratch& s) const noexcept;
  void gather_times(const Warp& warp, std::int32_t k, Scratch& s) const noexcept;
  void support_sum(std::span<std::uint32_t> values, Scratch& s, int shift) const noexcept;
  [[nodiscard]] std::uint32_t expected(std::uint32_t counts) const noexcept;

  FocusCost cost_;
  std::int32_t support_;
  Intrinsics grid_;
  CellGrid cells_;
  std::uint32_t weight_;                // n
  int numerator_shift_ = 0;             // keeps A in 32 bits
  int table_shift_ = 0;                 // S >> shift indexes expected_
  std::span<std::uint32_t> per_count_;  // g of a single pixel, by its count
  std::span<std::uint32_t> expected_;   // n J, by density
  Scratch scratch_[kMaxParts];
};

}  // namespace egofocus
