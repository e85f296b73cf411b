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

std::size_t pixels_of(const Intrinsics& grid) noexcept {
  return static_cast<std::size_t>(grid.width_px) * static_cast<std::size_t>(grid.height_px);
}

std::size_t half_bytes(const Intrinsics& grid, std::int32_t hypotheses) noexcept {
  return static_cast<std::size_t>(hypotheses) * half_counts_bytes(cell_grid(grid).size());
}

std::size_t aligned(std::size_t bytes) noexcept {
  return (bytes + Arena::kAlignment - 1) / Arena::kAlignment * Arena::kAlignment;
}

std::int32_t smaller(std::int32_t a, std::int32_t b) noexcept {
  return a < b ? a : b;
}

}  // namespace

StackLayout::StackLayout(const Intrinsics& grid, std::int32_t hypotheses, std::int32_t max_events,
                         int threads) noexcept
    : at_once(smaller(hypotheses, Warp::kPlanesAtOnce * threads)),
      placed((hypotheses - 1) / at_once * at_once),
      lines_at(aligned(static_cast<std::size_t>(placed) * FocusInput::sums_bytes(grid, 1))),
      planes_at(lines_at + Warp::lines_bytes(max_events)),
      sums_bytes(FocusInput::sums_bytes(grid, hypotheses)) {
  if (planes_at < aligned(sums_bytes)) planes_at = aligned(sums_bytes);
  bytes = planes_at + static_cast<std::size_t>(at_once) * pixels_of(grid);
}

NetworkMemory::NetworkMemory(const Config& config, const Model& model, Arena& arena) noexcept
    : grid_(working_grid(config)),
      buffers_(model.facts, grid_, config.threads, plan_),
      stack_(grid_, config.ladder.hypotheses, config.window.max_events, config.threads) {
  const std::int32_t hypotheses = config.ladder.hypotheses;
  const FocusInputConfig& input = model.facts.input;
  const std::size_t idle_bytes = sizeof(std::uint32_t) * pixels_of(grid_);
  stack_id_ = plan_.add(stack_.bytes > idle_bytes ? stack_.bytes : idle_bytes, kStepVote, kStepVote,
                        stack_.sums_bytes, kStepInput);
  half_id_ = plan_.add(half_bytes(grid_, hypotheses), kStepVote, kStepRefine);
  for (int i = 0; i < config.threads; ++i)
    counts_id_[i] = plan_.add(cell_grid(grid_).size(), kStepVote, kStepVote);
  rows_id_ = plan_.add(FocusInput::rows_bytes(grid_, hypotheses, config.threads), kStepInput, kStepInput);
  focus_id_ = plan_.add(FocusInput::focus_bytes(input, grid_, hypotheses), kStepInput, kStepFocusCost);
  context_id_ = plan_.add(FocusInput::context_bytes(input, grid_), kStepInput, kStepScores);
  plan_.place(arena);
}

std::span<std::uint32_t> NetworkMemory::idle() const noexcept {
  return plan_.arena(stack_id_).array<std::uint32_t>(pixels_of(grid_));
}

FocusInput NetworkBackend::make_input(const Config& config, const Model& model, const NetworkMemory& memory,
                                      Arena& arena) noexcept {
  const MemoryPlan& plan = memory.plan_;
  Arena sums = plan.arena(memory.stack_id_);
  Arena rows = plan.arena(memory.rows_id_);
  Arena focus = plan.arena(memory.focus_id_);
  Arena context = plan.arena(memory.context_id_);
  return FocusInput(model.facts.input, memory.grid_, config.ladder.hypotheses, config.threads,
                    {arena, sums, rows, focus, context});
}

NetworkBackend::NetworkBackend(const Config& config, const Model& model, const KernelTable& kernels,
                               const NetworkMemory& memory, Arena& arena) noexcept
    : grid_(memory.grid_),
      stack_(memory.stack_),
      input_(make_input(config, model, memory, arena)),
      half_(memory.plan_.arena(memory.half_id_)
                .array<std::uint8_t>(half_bytes(grid_, config.ladder.hypotheses))),
      planes_(memory.plan_.arena(memory.stack_id_, stack_.planes_at)
                  .array<std::uint8_t>(static_cast<std::size_t>(stack_.at_once) * pixels_of(grid_))),
      network_(model, grid_, kernels, config.threads, memory.buffers_, memory.plan_, arena) {
  for (int i = 0; i < config.threads; ++i)
    counts_[i] = memory.plan_.arena(memory.counts_id_[i]).array<std::uint8_t>(cell_grid(grid_).size());
}

void NetworkBackend::vote(Warp& warp, const HypothesisLadder& ladder, const double (&baseline_m)[3],
                          WorkerPool& pool) noexcept {
  const std::size_t pixels = pixels_of(grid_);
  used_ = ladder.count;
  input_.begin(ladder, baseline_m);
  // Each thread has its planes, and votes its share of the hypotheses that are placed in them; the others are
  // shared out once more.
  const std::int32_t placed = smaller(used_, stack_.placed);
  const std::int32_t last = used_ - placed;
  in_parts(pool, [&](int part, int parts) noexcept {
    std::uint8_t* const planes =
        planes_.data() + static_cast<std::size_t>(stack_.at_once * part / parts) * pixels;
    const std::int32_t room = stack_.at_once * (part + 1) / parts - stack_.at_once * part / parts;
    const std::int32_t end = placed * (part + 1) / parts;
    std::int32_t count = 0;
    for (std::int32_t first = placed * part / parts; first < end; first += count) {
      count = smaller(end - first, room);
      __builtin_memset(planes, 0, static_cast<std::size_t>(count) * pixels);
      warp.add_votes(first, count, part, planes);
      for (std::int32_t i = 0; i < count; ++i) keep(first + i, stack_.at_once * part / parts + i, part);
    }
  });
  if (last == 0) return;
  in_parts(pool, [&](int part, int parts) noexcept {
    const std::int32_t first = last * part / parts;
    const std::int32_t count = last * (part + 1) / parts - first;
    std::uint8_t* const planes = planes_.data() + static_cast<std::size_t>(first) * pixels;
    __builtin_memset(planes, 0, static_cast<std::size_t>(count) * pixels);
    if (count > 0) warp.add_votes(placed + first, count, part, planes);
  });
  in_parts(pool, [&](int part, int parts) noexcept {  // the lines are of no use any more
    for (std::int32_t i = last * part / parts; i < last * (part + 1) / parts; ++i) keep(placed + i, i, part);
  });
}

// What the network is told of hypothesis k.
void NetworkBackend::keep(std::int32_t k, std::int32_t plane, int part) noexcept {
  const std::size_t pixels = pixels_of(grid_);
  const auto counts = planes_.subspan(static_cast<std::size_t>(plane) * pixels, pixels);
  input_.add_plane(k, counts, part);
  halve_counts(counts, grid_.width_px, grid_.height_px, counts_[part]);
  pack_half_counts(counts_[part],
                   &half_[static_cast<std::size_t>(k) * half_counts_bytes(cell_grid(grid_).size())]);
}

}  // namespace egofocus
