// The network in a tick: its input, itself, and the memory that they share with the warp.
#pragma once

#include "core/arena.hpp"
#include "core/worker_pool.hpp"
#include "egofocus/config.hpp"
#include "kernels/kernel_table.hpp"
#include "pipeline/focus_input.hpp"
#include "pipeline/memory_plan.hpp"
#include "pipeline/model.hpp"
#include "pipeline/network.hpp"
#include "pipeline/warp.hpp"

namespace egofocus {

/// Reads Config::model, or the embedded one, into `model_out` and puts what the model dictates (ladder but
/// z_near_m, max_events) into `config`. Errors: those of read_model(); kBadModel without bytes;
/// kModelMismatch for another grid. Other backends: nothing to do. RT: no (set-up).
Status adopt_model(Config& config, Model& model_out) noexcept;

/// One block for the landing lines, some planes of counts, and the sums that are made of all planes:
///   [sums][lines][planes]
/// in the smaller of two ways:
/// - Half of the planes at once, lines of kLeastLines events or more, and a place of its own for the first
///   half's sums alone. Those of the second half find room: a few where the lines were, which have all been
///   voted by then, and the rest where the planes of those few were. A window of more events than there are
///   lines for is projected anew for each half.
/// - A few planes for each thread, all lines, all sums: on large grids, where a plane is more than lines are.
/// Sums lie one after the other in the end.
struct StackLayout {
  static constexpr std::int32_t kLeastLines = 16'384;
  StackLayout(const Intrinsics& grid, std::int32_t hypotheses, std::int32_t max_events, int threads) noexcept;

  std::int32_t at_once;      ///< hypotheses whose planes there are
  std::int32_t placed;       ///< hypotheses whose sums have a place of their own: the first half, or all
  std::int32_t early;        ///< those after them whose sums lie where the lines were
  std::int32_t line_events;  ///< events whose lines there is room for
  std::size_t lines_at;      ///< bytes from the block's begin
  std::size_t planes_at;
  std::size_t sums_bytes;
  std::size_t bytes;
};

/// What lives in some steps of a tick only; made before the warp, which takes its lines from it.
class NetworkMemory {
 public:
  NetworkMemory(const Config& config, const Model& model, Arena& arena) noexcept;
  [[nodiscard]] const StackLayout& stack() const noexcept { return stack_; }
  [[nodiscard]] Arena lines() const noexcept { return plan_.arena(stack_id_, stack_.lines_at); }
  /// One value per grid pixel, for a tick without a network.
  [[nodiscard]] std::span<std::uint32_t> idle() const noexcept;
  [[nodiscard]] const MemoryPlan& plan() const noexcept { return plan_; }

 private:
  friend class NetworkBackend;
  Intrinsics grid_;
  MemoryPlan plan_;
  Network::Buffers buffers_;
  StackLayout stack_;
  std::int32_t stack_id_;
  std::int32_t half_id_;
  std::int32_t rows_id_;
  std::int32_t focus_id_;
  std::int32_t context_id_;
  std::int32_t counts_id_[WorkerPool::kMaxParts] = {};
};

class NetworkBackend {
 public:
  NetworkBackend(const Config& config, const Model& model, const KernelTable& kernels,
                 const NetworkMemory& memory, Arena& arena) noexcept;

  /// In this order, once a tick. vote(): projects and votes, some planes at a time, none of which is kept.
  /// Thread: the tick. RT: yes.
  void vote(Warp& warp, const WarpTask& task, WorkerPool& pool) noexcept;
  void prepare_input(WorkerPool& pool) noexcept { input_.finish(pool); }
  /// Valid until the next call.
  CellDepth run(WorkerPool& pool) noexcept {
    return network_.run({input_.focus(), input_.context(), half_, used_}, pool);
  }

 private:
  struct Planes {
    std::int32_t begin, end;
  };
  static FocusInput make_input(const Config& config, const Model& model, const NetworkMemory& memory,
                               Arena& arena) noexcept;
  void vote_planes(Warp& warp, const WarpTask& task, Planes of, WorkerPool& pool) noexcept;
  void keep(std::int32_t first, Planes planes, int part) noexcept;

  Intrinsics grid_;
  StackLayout stack_;
  FocusInput input_;
  std::span<std::uint8_t> half_;                           // pack_half_counts() of each hypothesis
  std::span<std::uint8_t> planes_;                         // [stack_.at_once][height][width]
  std::span<std::uint8_t> counts_[WorkerPool::kMaxParts];  // [cells of 2x2 px]
  std::int32_t used_ = 0;                                  // hypotheses of the tick
  Network network_;
};

}  // namespace egofocus
