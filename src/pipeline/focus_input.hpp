// What the network is told of a tick: how sharp each hypothesis is, per cell of 4x4 pixels, and a few maps of
// context. Integers from the images of warped events on; docs/integer_model.md, "The network's input",
// defines every byte. Training calls this very code.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "core/worker_pool.hpp"
#include "egofocus/config.hpp"
#include "egofocus/status.hpp"
#include "pipeline/focus_energy.hpp"
#include "pipeline/hypothesis_ladder.hpp"
#include "pipeline/sharpness.hpp"

namespace egofocus {

enum class FocusMapKind : std::uint8_t { kGradient, kGradientX, kGradientY, kSquares };

/// An energy (kGradient: the sum of both directions) under a support of side x side cells, applied twice.
struct FocusMap {
  FocusMapKind kind = FocusMapKind::kGradient;
  std::int32_t side = 1;  ///< 1, 3, 5 or 7
};

struct FocusInputConfig {
  static constexpr std::int32_t kMostMaps = 8;
  FocusMap maps[kMostMaps];
  std::int32_t map_count = 1;             ///< 1..8
  std::int32_t floor_events_milli = 50;   ///< 20..2000 thousandths of an event per pixel
  std::int32_t floor_noise_milli = 1000;  ///< 100..8000 thousandths of q
};

class FocusInput {
 public:
  static constexpr std::int32_t kMostHypotheses = 64;
  static Status check(const FocusInputConfig& config) noexcept;

  /// Takes from the arena: 8 bytes per hypothesis and cell, the outputs, and 14 bytes per hypothesis and cell
  /// of a row for each part. `hypotheses` (D): 1..64.
  FocusInput(const FocusInputConfig& config, const Intrinsics& grid, std::int32_t hypotheses, int parts,
             Arena& arena) noexcept
      : FocusInput(config, grid, hypotheses, parts, {arena, arena, arena, arena, arena}) {}
  /// The same from arenas of their own, by what they are needed for.
  struct Memory {
    Arena& always;
    Arena& sums;   ///< from add_plane() to finish(); those of hypothesis k at k times sums_bytes(grid, 1)
    Arena& rows;   ///< in finish()
    Arena& focus;  ///< outputs: written by finish()
    Arena& context;
  };
  FocusInput(const FocusInputConfig& config, const Intrinsics& grid, std::int32_t hypotheses, int parts,
             const Memory& memory) noexcept;
  [[nodiscard]] static std::size_t sums_bytes(const Intrinsics& grid, std::int32_t hypotheses) noexcept;
  [[nodiscard]] static std::size_t rows_bytes(const Intrinsics& grid, std::int32_t hypotheses,
                                              int parts) noexcept;
  [[nodiscard]] static std::size_t focus_bytes(const FocusInputConfig& config, const Intrinsics& grid,
                                               std::int32_t hypotheses) noexcept;
  [[nodiscard]] static std::size_t context_bytes(const FocusInputConfig& config,
                                                 const Intrinsics& grid) noexcept;

  /// `planes`: counts [ladder.count][height][width] of the grid, as Warp::planes() has them; ladder.count:
  /// 1..D. `baseline_m`: the camera's centre at the window's begin, seen at its end. The outputs are valid
  /// until the next call. Thread: the tick. RT: yes.
  void run(std::span<const std::uint8_t> planes, const HypothesisLadder& ladder,
           const double (&baseline_m)[3], WorkerPool& pool) noexcept;

  /// The same in pieces, by whoever has one plane at a time: begin(), each plane of hypothesis k <
  /// ladder.count once (by any part, also at once), finish(). RT: yes.
  void begin(const HypothesisLadder& ladder, const double (&baseline_m)[3]) noexcept;
  void add_plane(std::int32_t k, std::span<const std::uint8_t> plane, int part) noexcept;
  void finish(WorkerPool& pool) noexcept;

  [[nodiscard]] const EnergyGrid& cells() const noexcept { return cells_; }
  /// density at sides 1 and 7, contrast of each map, parallax of one hypothesis x, y, norm, share of D
  [[nodiscard]] std::int32_t context_channels() const noexcept { return config_.map_count + 6; }
  /// [D][maps][cells], steps of 1/8: z of each hypothesis; kInputZero from ladder.count on.
  [[nodiscard]] std::span<const std::uint8_t> focus() const noexcept { return focus_; }
  /// [channels][cells], steps of 1/32.
  [[nodiscard]] std::span<const std::uint8_t> context() const noexcept { return context_; }

 private:
  static constexpr int kMaxParts = WorkerPool::kMaxParts;
  struct Scratch {
    std::span<std::uint32_t> strip;       // sum_cells()'
    std::span<std::uint32_t> counts;      // [D][width]
    std::span<std::uint32_t> reciprocal;  // [D][width]
    std::span<std::uint32_t> ratio;       // [D][width]
    std::span<std::int16_t> deviation;    // [D][width]
    std::span<std::uint32_t> line;
    std::span<std::uint32_t> count_sum;  // [width]
    SharpnessRow row;
  };
  static void take_rows(Scratch& s, std::size_t depth, std::size_t padded, Arena& arena) noexcept;
  void displacements(const HypothesisLadder& ladder, const double (&baseline_m)[3]) noexcept;
  void rows(int part, int parts) noexcept;
  void support(std::int32_t side, std::int32_t y, Scratch& s) noexcept;
  void parallax(std::int32_t y) noexcept;
  [[nodiscard]] bool has_map(std::int32_t side) const noexcept;
  [[nodiscard]] std::span<std::uint16_t> sums(std::size_t map, std::int32_t k) const noexcept;

  FocusInputConfig config_;
  Intrinsics grid_;
  EnergyGrid cells_;
  std::int32_t hypotheses_;
  std::uint32_t floor_noise_q20_;
  SupportScale scale_[4];
  bool has_direction_ = false;  // some map is of one direction's gradients
  // [D][gradient_x, gradient_y, squares, counts][cells]; where no map tells directions apart, the first has
  // both, and the second what did not fit.
  std::span<std::uint16_t> sums_;
  bool adds_second_[kMostHypotheses] = {};  // the sum of gradients is in two maps
  std::span<std::uint8_t> focus_;
  std::span<std::uint8_t> context_;
  std::span<std::int32_t> column_q8_;  // [width] px of one hypothesis
  std::span<std::int32_t> row_q8_;     // [height]
  Scratch scratch_[kMaxParts];
  std::int32_t used_ = 0;
};

}  // namespace egofocus
