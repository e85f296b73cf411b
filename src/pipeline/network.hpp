// The network backend: what FocusInput tells of a tick -> index and confidence, in integers. The stages stand
// in docs/integer_model.md, "The network", which defines every byte.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "core/worker_pool.hpp"
#include "kernels/kernel_table.hpp"
#include "pipeline/conv_layer.hpp"
#include "pipeline/focus.hpp"
#include "pipeline/focus_energy.hpp"
#include "pipeline/memory_plan.hpp"
#include "pipeline/model.hpp"
#include "pipeline/regression.hpp"
#include "pipeline/tensor.hpp"

namespace egofocus {

/// Steps of a tick, for the memory plan. What lives in one of them only may lie where another one's lies.
enum NetworkStep : int {
  kStepVote,
  kStepInput,
  kStepFocusCost,
  kStepMix,
  kStepAt4,
  kStepAt8,
  kStepAt16,
  kStepUp8,
  kStepUp4,
  kStepScores,
  kStepRefine,
};

/// What it looks at, as in docs/integer_model.md, "The network's input".
struct NetworkInputs {
  std::span<const std::uint8_t> focus;    ///< [D][maps][cells]
  std::span<const std::uint8_t> context;  ///< [maps + 6][cells]
  std::span<const std::uint8_t> half;     ///< pack_half_counts() of [used or more][cells of 2x2 px]
  std::int32_t used = 0;                  ///< hypotheses: 1..D
};

/// For tests and pictures: sees each tensor when it is complete, before another may take its place.
struct NetworkWatcher {
  void* self = nullptr;
  void (*bytes)(void* self, const char* name, const Tensor& tensor) = nullptr;
};

class Network {
 public:
  /// Enters its buffers into the plan. Between the two constructions of an engine, plan.place().
  class Buffers {
   public:
    Buffers(const ModelFacts& facts, const Intrinsics& grid, int parts, MemoryPlan& plan) noexcept;

   private:
    friend class Network;
    TensorShape at_4, at_8, at_16, guide, focus_in, focus_hidden, mixed, refine_in, refine;
    std::int32_t mixed_id, at_4_id, inner_4_id, inner_up_4_id, at_8_id, inner_8_id, inner_up_8_id, at_16_id,
        inner_16_id, small_8_id, small_4_id, index_4_id, confidence_4_id, spread_4_id, guide_id, start_id,
        change_id, refine_in_id, refine_id[2], index_id, confidence_id;
    std::int32_t focus_in_id[WorkerPool::kMaxParts], focus_hidden_id[WorkerPool::kMaxParts],
        scores_id[WorkerPool::kMaxParts];
  };

  /// Packs the model's weights into the arena; `plan` has been placed and holds `buffers`. RT: no (set-up).
  Network(const Model& model, const Intrinsics& grid, const KernelTable& kernels, int parts,
          const Buffers& buffers, const MemoryPlan& plan, Arena& arena) noexcept;

  /// Runs on the pool; the result is valid until the next call. Every cell has an estimate: confidence is at
  /// least 1. Thread: the tick. RT: yes.
  CellDepth run(const NetworkInputs& inputs, WorkerPool& pool) noexcept;

  void watch(const NetworkWatcher& watcher) noexcept { watcher_ = watcher; }

 private:
  static constexpr std::int32_t kMostBlocks = 8;
  struct Block {
    ConvLayer first;
    ConvLayer second;
  };
  struct Blocks {
    Block of[kMostBlocks];
    std::int32_t count = 0;
  };
  Blocks make_blocks(const Model& model, LayerRole role, std::int32_t count, std::int32_t width,
                     const KernelTable& kernels, Arena& arena) noexcept;

  void focus_costs(int part, int parts) noexcept;
  void take_maps(std::int32_t k, const Tensor& to, std::int32_t first) const noexcept;
  void mix(int part, int parts) noexcept;
  void run_blocks(const Blocks& blocks, const Tensor& sum, const Tensor& inner, WorkerPool& pool) noexcept;
  void down(const ConvLayer& layer, const Tensor& from, const Tensor& to, WorkerPool& pool) noexcept;
  void join(const ConvLayer& narrow, const Tensor& from, const Tensor& to, std::int8_t* small,
            WorkerPool& pool) noexcept;
  void scores(int part, int parts) noexcept;
  void refine_input(int part, int parts) noexcept;
  void refine_output(int part, int parts) noexcept;
  void nearer_at_borders(int part, int parts) noexcept;
  void refine(WorkerPool& pool) noexcept;
  void show(const char* name, const Tensor& tensor) const noexcept;

  ModelFacts facts_;
  std::int32_t together_;  // hypotheses that one convolution looks at, as its channels are multiples of 4
  EnergyGrid cells_;       // of 4x4 px
  CellGrid halves_;        // of 2x2 px
  Regression regression_;
  ConvLayer focus_layers_[2];
  ConvLayer mix_, down_8_, down_16_, narrow_16_, narrow_8_, head_, own_, guide_, first_, last_;
  ConvLayer body_[ModelFacts::kMostDilations];
  Blocks blocks_4_, blocks_8_, blocks_16_, blocks_up_8_, blocks_up_4_;

  Tensor focus_in_[WorkerPool::kMaxParts], focus_hidden_[WorkerPool::kMaxParts];
  Tensor mixed_;  // [C_0 .. C_D-1, context]
  Tensor at_4_, inner_4_, inner_up_4_, at_8_, inner_8_, inner_up_8_, at_16_, inner_16_;
  Tensor guide_4_, refine_in_, refine_[2];
  std::int8_t* small_8_ = nullptr;
  std::int8_t* small_4_ = nullptr;
  std::int16_t* scores_[WorkerPool::kMaxParts] = {};  // head, own: [width][D] each
  std::uint16_t* index_4_ = nullptr;
  std::uint8_t* confidence_4_ = nullptr;
  std::span<std::uint16_t> spread_4_;
  std::uint16_t* start_ = nullptr;  // index up-sampled to halves; then refined
  std::int16_t* change_ = nullptr;
  std::span<std::uint16_t> index_q8_;
  std::span<std::uint8_t> confidence_;

  NetworkInputs inputs_;
  NetworkWatcher watcher_;
};

}  // namespace egofocus
