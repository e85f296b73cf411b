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

/// One block for the landing lines, a few planes of counts, and the sums that are made of all planes:
///   [sums][lines][planes]
/// The sums of the hypotheses that are voted last take the place of the lines, which nobody needs any more by
/// then: so sums lie one after the other, and there is room of their own for the others' alone.
struct StackLayout {
  StackLayout(const Intrinsics& grid, std::int32_t hypotheses, std::int32_t max_events, int threads) noexcept;

  std::int32_t at_once;  ///< hypotheses whose planes there are: Warp::kPlanesAtOnce for each thread
  std::int32_t
      placed;  ///< hypotheses whose sums have a place of their own: all but the last at_once or fewer
  std::size_t lines_at;  ///< bytes from the block's begin
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
  static FocusInput make_input(const Config& config, const Model& model, const NetworkMemory& memory,
                               Arena& arena) noexcept;
  void keep(std::int32_t k, std::int32_t plane, int part) noexcept;

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
