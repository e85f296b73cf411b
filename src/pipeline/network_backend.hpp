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

/// What lives in some steps of a tick only; made before the warp, which takes its lines from it.
class NetworkMemory {
 public:
  NetworkMemory(const Config& config, const Model& model, Arena& arena) noexcept;
  [[nodiscard]] Arena lines() const noexcept { return plan_.arena(lines_); }
  [[nodiscard]] const MemoryPlan& plan() const noexcept { return plan_; }

 private:
  friend class NetworkBackend;
  MemoryPlan plan_;
  Network::Buffers buffers_;
  std::int32_t lines_ = 0;
  std::int32_t sums_ = 0;
  std::int32_t focus_ = 0;
  std::int32_t half_ = 0;
  std::int32_t planes_[WorkerPool::kMaxParts] = {};
  std::int32_t counts_[WorkerPool::kMaxParts] = {};
};

class NetworkBackend {
 public:
  NetworkBackend(const Config& config, const Model& model, const KernelTable& kernels,
                 const NetworkMemory& memory, Arena& arena) noexcept;

  /// In this order, once a tick. vote(): what `warp` has projected, a few planes at a time, none of which is
  /// kept; baseline_m as in Focus::run(). Thread: the tick. RT: yes.
  void vote(Warp& warp, const HypothesisLadder& ladder, const double (&baseline_m)[3],
            WorkerPool& pool) noexcept;
  void prepare_input(WorkerPool& pool) noexcept { input_.finish(pool); }
  /// Valid until the next call.
  CellDepth run(WorkerPool& pool) noexcept {
    return network_.run({input_.focus(), input_.context(), half_, used_}, pool);
  }

 private:
  NetworkBackend(const Config& config, const Model& model, const KernelTable& kernels,
                 const NetworkMemory& memory, Arena& arena, Arena sums, Arena focus) noexcept;

  Intrinsics grid_;
  FocusInput input_;
  std::span<std::uint8_t> half_;                           // pack_half_counts() of each hypothesis
  std::span<std::uint8_t> planes_[WorkerPool::kMaxParts];  // [Warp::kPlanesAtOnce][height][width]
  std::span<std::uint8_t> counts_[WorkerPool::kMaxParts];  // [cells of 2x2 px]
  std::int32_t used_ = 0;                                  // hypotheses of the tick
  Network network_;
};

}  // namespace egofocus
