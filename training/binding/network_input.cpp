#include "network_input.hpp"

#include "arena_memory.hpp"
#include "recording/replay.hpp"

namespace egofocus::training {

NetworkInput network_input(const FocusInputConfig& config, const Intrinsics& grid, std::int32_t hypotheses,
                           std::span<const std::uint8_t> planes, const HypothesisLadder& ladder,
                           const double (&baseline_m)[3], WorkerPool& pool) {
  recording::require(FocusInput::check(config), "window");
  Arena counter;
  const FocusInput counted(config, grid, hypotheses, pool.parts(), counter);
  const ArenaMemory memory(counter.used_bytes());
  Arena arena(memory.span());
  FocusInput input(config, grid, hypotheses, pool.parts(), arena);
  input.run(planes, ladder, baseline_m, pool);
  return {input.cells(),
          {input.focus().begin(), input.focus().end()},
          {input.context().begin(), input.context().end()}};
}

}  // namespace egofocus::training
