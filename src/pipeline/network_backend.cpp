#include "pipeline/network_backend.hpp"

#include "pipeline/embedded_model.hpp"
#include "pipeline/half_counts.hpp"
#include "pipeline/in_parts.hpp"
#include "pipeline/working_grid.hpp"

namespace egofocus {

Status adopt_model(Config& config, Model& model_out) noexcept {
  if (config.backend != Backend::kNetwork) return {};
  const std::span<const std::byte> bytes = config.model.empty() ? embedded_model() : config.model;
  if (bytes.empty()) return {StatusCode::kBadModel, "Config::model is empty, and the library embeds none"};
  if (const Status status = read_model(bytes, model_out); !status.ok()) return status;
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

namespace {

std::size_t group_bytes(const Intrinsics& grid) noexcept {
  return static_cast<std::size_t>(Warp::kPlanesAtOnce) * static_cast<std::size_t>(grid.width_px) *
         static_cast<std::size_t>(grid.height_px);
}

std::size_t half_bytes(const Intrinsics& grid, std::int32_t hypotheses) noexcept {
  return static_cast<std::size_t>(hypotheses) * half_counts_bytes(cell_grid(grid).size());
}

}  // namespace

NetworkMemory::NetworkMemory(const Config& config, const Model& model, Arena& arena) noexcept
    : buffers_(model.facts, working_grid(config), config.threads, plan_) {
  const Intrinsics grid = working_grid(config);
  const std::int32_t hypotheses = config.ladder.hypotheses;
  lines_ = plan_.add(Warp::lines_bytes(config.window.max_events), kStepVote, kStepVote);
  for (int i = 0; i < config.threads; ++i) {
    planes_[i] = plan_.add(group_bytes(grid), kStepVote, kStepVote);
    counts_[i] = plan_.add(cell_grid(grid).size(), kStepVote, kStepVote);
  }
  sums_ = plan_.add(FocusInput::sums_bytes(grid, hypotheses), kStepVote, kStepInput);
  half_ = plan_.add(half_bytes(grid, hypotheses), kStepVote, kStepRefine);
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
    : grid_(working_grid(config)),
      input_(model.facts.input, grid_, config.ladder.hypotheses, config.threads, arena, sums, focus),
      half_(
          memory.plan_.arena(memory.half_).array<std::uint8_t>(half_bytes(grid_, config.ladder.hypotheses))),
      network_(model, grid_, kernels, config.threads, memory.buffers_, memory.plan_, arena) {
  for (int i = 0; i < config.threads; ++i) {
    planes_[i] = memory.plan_.arena(memory.planes_[i]).array<std::uint8_t>(group_bytes(grid_));
    counts_[i] = memory.plan_.arena(memory.counts_[i]).array<std::uint8_t>(cell_grid(grid_).size());
  }
}

void NetworkBackend::vote(Warp& warp, const HypothesisLadder& ladder, const double (&baseline_m)[3],
                          WorkerPool& pool) noexcept {
  constexpr std::int32_t kGroup = Warp::kPlanesAtOnce;
  const std::size_t pixels = group_bytes(grid_) / kGroup;
  const std::size_t half_plane = half_counts_bytes(cell_grid(grid_).size());
  const std::int32_t groups = (ladder.count + kGroup - 1) / kGroup;
  used_ = ladder.count;
  input_.begin(ladder, baseline_m);
  in_parts(pool, [&](int part, int parts) noexcept {
    for (std::int32_t group = groups * part / parts; group < groups * (part + 1) / parts; ++group) {
      const std::int32_t first = group * kGroup;
      const std::int32_t count = ladder.count - first < kGroup ? ladder.count - first : kGroup;
      warp.vote_planes(first, count, part, planes_[part]);
      for (std::int32_t i = 0; i < count; ++i) {
        const auto plane = planes_[part].subspan(static_cast<std::size_t>(i) * pixels, pixels);
        input_.add_plane(first + i, plane, part);
        halve_counts(plane, grid_.width_px, grid_.height_px, counts_[part]);
        pack_half_counts(counts_[part], &half_[static_cast<std::size_t>(first + i) * half_plane]);
      }
    }
  });
}

}  // namespace egofocus
