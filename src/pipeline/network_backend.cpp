#include "pipeline/network_backend.hpp"

#include "pipeline/working_grid.hpp"

namespace egofocus {

Status adopt_model(Config& config, Model& model_out) noexcept {
  if (config.backend != Backend::kNetwork) return {};
  if (config.model.empty()) return {StatusCode::kBadModel, "backend network without a model (Config::model)"};
  if (const Status status = read_model(config.model, model_out); !status.ok()) return status;
  const ModelFacts& facts = model_out.facts;
  const Intrinsics grid = working_grid(config);
  if (facts.grid_width_px != 0 && grid.width_px != facts.grid_width_px)
    return {StatusCode::kModelMismatch, "grid width", grid.width_px, facts.grid_width_px};
  if (facts.grid_height_px != 0 && grid.height_px != facts.grid_height_px)
    return {StatusCode::kModelMismatch, "grid height", grid.height_px, facts.grid_height_px};
  const double z_near_m = config.ladder.z_near_m;
  config.ladder = facts.ladder;
  config.ladder.z_near_m = z_near_m;
  config.window.max_events = facts.max_events;
  return {};
}

NetworkMemory::NetworkMemory(const Config& config, const Model& model, Arena& arena) noexcept
    : buffers_(model.facts, working_grid(config), config.threads, plan_) {
  const Intrinsics grid = working_grid(config);
  const std::int32_t hypotheses = config.ladder.hypotheses;
  lines_ = plan_.add(Warp::lines_bytes(config.window.max_events), kStepProject, kStepProject);
  sums_ = plan_.add(FocusInput::sums_bytes(grid, hypotheses), kStepInput, kStepInput);
  focus_ =
      plan_.add(FocusInput::focus_bytes(model.facts.input, grid, hypotheses), kStepInput, kStepFocusCost);
  plan_.place(arena);
}

NetworkBackend::NetworkBackend(const Config& config, const Model& model, const KernelTable& kernels,
                               const NetworkMemory& memory, Arena& arena) noexcept
    : NetworkBackend(config, model, kernels, memory, arena, memory.plan_.arena(memory.sums_),
                     memory.plan_.arena(memory.focus_)) {}

NetworkBackend::NetworkBackend(const Config& config, const Model& model, const KernelTable& kernels,
                               const NetworkMemory& memory, Arena& arena, Arena sums, Arena focus) noexcept
    : input_(model.facts.input, working_grid(config), config.ladder.hypotheses, config.threads, arena, sums,
             focus),
      network_(model, working_grid(config), kernels, config.threads, memory.buffers_, memory.plan_, arena) {}

CellDepth NetworkBackend::run(const Warp& warp, const HypothesisLadder& ladder, const double (&baseline_m)[3],
                              WorkerPool& pool) noexcept {
  input_.run(warp.planes(), ladder, baseline_m, pool);
  return network_.run({input_.focus(), input_.context(), warp.planes(), ladder.count}, pool);
}

}  // namespace egofocus
