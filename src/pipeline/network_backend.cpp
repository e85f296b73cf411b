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
                         int threads) noexcept {
  constexpr std::int32_t kGroup = Warp::kPlanesAtOnce;
  const std::size_t plane = pixels_of(grid);
  const std::size_t sums = FocusInput::sums_bytes(grid, 1);
  sums_bytes = static_cast<std::size_t>(hypotheses) * sums;
  at_once = smaller(hypotheses, ((hypotheses + 1) / 2 + kGroup - 1) / kGroup * kGroup);
  placed = at_once;
  line_events = smaller(max_events, kLeastLines);
  lines_at = aligned(static_cast<std::size_t>(placed) * sums);
  planes_at = lines_at + Warp::lines_bytes(line_events);
  // The fewest whose planes make room for the sums of the others: with all of them there are no others.
  early = 0;
  while (planes_at + static_cast<std::size_t>(early) * plane < sums_bytes) {
    ++early;
    const std::size_t early_end = aligned(static_cast<std::size_t>(placed + early) * sums);
    if (early_end > planes_at) planes_at = early_end;
  }
  while (line_events < max_events && lines_at + Warp::lines_bytes(line_events + 64) <= planes_at)
    line_events += 64;
  bytes = planes_at + static_cast<std::size_t>(at_once) * plane;

  const std::int32_t few = smaller(hypotheses, kGroup * threads);
  const std::size_t beyond_lines = aligned(sums_bytes) + Warp::lines_bytes(max_events);
  const std::size_t by_few = beyond_lines + static_cast<std::size_t>(few) * plane;
  if (by_few >= bytes) return;
  at_once = few;
  placed = hypotheses;
  early = 0;
  line_events = max_events;
  lines_at = aligned(sums_bytes);
  planes_at = beyond_lines;
  bytes = by_few;
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

void NetworkBackend::vote(Warp& warp, const WarpTask& task, WorkerPool& pool) noexcept {
  used_ = task.ladder.count;
  input_.begin(task.ladder, task.track.knots[0].centre_m);
  warp.begin(task.ladder, pool.parts());
  for (std::int32_t first = 0; first < used_; first += stack_.at_once) {
    const std::int32_t count = smaller(used_ - first, stack_.at_once);
    vote_planes(warp, task, {first, first + count}, pool);
    if (first < stack_.placed) continue;
    const std::int32_t early = smaller(count, stack_.early);
    for (const auto& [from, end] : {Planes{0, early}, Planes{early, count}}) {
      in_parts(pool, [&, from = from, size = end - from](int part, int parts) noexcept {
        keep(first, {from + size * part / parts, from + size * (part + 1) / parts}, part);
      });
    }
  }
}

// Votes of all events for some hypotheses. Sums that have a place of their own are made while the planes are
// still at hand.
void NetworkBackend::vote_planes(Warp& warp, const WarpTask& task, Planes of, WorkerPool& pool) noexcept {
  const std::int32_t first = of.begin;
  const std::int32_t count = of.end - of.begin;
  const std::size_t pixels = pixels_of(grid_);
  const std::uint32_t events = task.selection.count;
  const auto at_once = static_cast<std::uint32_t>(stack_.line_events);
  for (std::uint32_t event = 0; event < events; event += at_once) {
    const std::uint32_t some = events - event < at_once ? events - event : at_once;
    if (first == 0 || events > at_once) {
      in_parts(pool, [&](int part, int parts) noexcept {
        warp.project_some(task, event, some, first == 0, part, parts);
      });
    }
    in_parts(pool, [&](int part, int parts) noexcept {
      const std::int32_t end = count * (part + 1) / parts;
      std::int32_t planes = 0;
      for (std::int32_t plane = count * part / parts; plane < end; plane += planes) {
        planes = smaller(end - plane, Warp::kPlanesAtOnce);
        std::uint8_t* const to = planes_.data() + static_cast<std::size_t>(plane) * pixels;
        if (event == 0) __builtin_memset(to, 0, static_cast<std::size_t>(planes) * pixels);
        warp.add_votes(first + plane, planes, part, to);
        if (first < stack_.placed && event + some == events) keep(first, {plane, plane + planes}, part);
      }
    });
  }
}

// What the network is told of some planes, the first of all being that of hypothesis `first`.
void NetworkBackend::keep(std::int32_t first, Planes planes, int part) noexcept {
  const std::size_t pixels = pixels_of(grid_);
  const std::size_t half_plane = half_counts_bytes(cell_grid(grid_).size());
  for (std::int32_t i = planes.begin; i < planes.end; ++i) {
    const auto plane = planes_.subspan(static_cast<std::size_t>(i) * pixels, pixels);
    input_.add_plane(first + i, plane, part);
    halve_counts(plane, grid_.width_px, grid_.height_px, counts_[part]);
    pack_half_counts(counts_[part], &half_[static_cast<std::size_t>(first + i) * half_plane]);
  }
}

}  // namespace egofocus
