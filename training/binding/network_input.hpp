// What the network is told of a window, by the library's own stage.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/worker_pool.hpp"
#include "pipeline/focus_input.hpp"
#include "pipeline/hypothesis_ladder.hpp"

namespace egofocus::training {

struct NetworkInput {
  EnergyGrid cells;
  std::vector<std::uint8_t> focus;    ///< [D][maps][cells]
  std::vector<std::uint8_t> context;  ///< [channels][cells]
};

/// FocusInput::run() on planes [ladder.count][height][width]. Thread: the pool's owner. Uses the heap; throws
/// recording::Error (kConfiguration) for what FocusInput::check() refuses.
NetworkInput network_input(const FocusInputConfig& config, const Intrinsics& grid, std::int32_t hypotheses,
                           std::span<const std::uint8_t> planes, const HypothesisLadder& ladder,
                           const double (&baseline_m)[3], WorkerPool& pool);

}  // namespace egofocus::training
