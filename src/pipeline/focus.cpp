#include "pipeline/focus.hpp"

namespace egofocus {
namespace {

// The runner-up must lie further than this from the best: nearer ones are the same peak. A short ladder has
// a shorter reach, so that there is always a runner-up.
constexpr std::int32_t kPeakReach = 4;
constexpr std::uint32_t kPenaltyUnit =
    128;  // penalty of a hypothesis that is worse by the frame's mean contrast
constexpr std::uint32_t kSmallestContrast = 128;
constexpr std::uint32_t kLeastParallax_q4 =
    2 * 16;                                  // less between first and last hypothesis: nothing to choose from
constexpr std::uint32_t kHalfTrust_q4 = 16;  // a parallax of one pixel halves the confidence

struct Peak {
  std::int32_t best = 0;
  std::int32_t index_q8 = 0;
  std::int32_t gap = 0;  // by how much the best beats all that is not its own peak
};

// Smallest score; parabola through it and its neighbours.
Peak find_peak(const std::int32_t* score, std::int32_t hypotheses) noexcept {
  Peak peak;
  for (std::int32_t k = 1; k < hypotheses; ++k) {
    if (score[k] < score[peak.best]) peak.best = k;
  }
  const std::int32_t reach = hypotheses / 4 < kPeakReach ? hypotheses / 4 : kPeakReach;
  std::int32_t runner_up = INT32_MAX;
  for (std::int32_t k = 0; k < hypotheses; ++k) {
    const bool apart = k < peak.best - reach || k > peak.best + reach;
    if (apart && score[k] < runner_up) runner_up = score[k];
  }
  peak.gap = runner_up - score[peak.best];
  peak.index_q8 = peak.best * 256;
  if (peak.best > 0 && peak.best + 1 < hypotheses) {
    const std::int32_t left = score[peak.best - 1];
    const std::int32_t right = score[peak.best + 1];
    const std::int32_t curvature = left + right - 2 * score[peak.best];
    if (curvature > 0) peak.index_q8 += 128 * (left - right) / curvature;  // at most half a bin
  }
  return peak;
}

}  // namespace

Focus::Focus(const Config& config, int parts, Arena& arena) noexcept
    : config_(config.focus),
      grid_(working_grid(config)),
      cells_(cell_grid(grid_)),
      hypotheses_(config.ladder.hypotheses),
      plane_cost_(config.focus, working_grid(config), parts, arena),
      smoothing_(config.focus.smoothing ? cells_ : CellGrid{}, hypotheses_, parts, arena) {
  const auto volume = cells_.size() * static_cast<std::size_t>(hypotheses_);
  cost_ = arena.array<std::uint16_t>(volume);
  density_ = arena.array<std::uint16_t>(volume);
  if (config_.smoothing) penalty_ = arena.array<std::uint8_t>(volume);
  best_cost_ = arena.array<std::uint16_t>(cells_.size());
  index_q8_ = arena.array<std::uint16_t>(cells_.size());
  confidence_ = arena.array<std::uint8_t>(cells_.size());
  // Twice a box of r cells weighs like 3 r^3 / (2 r^2 + 1) cells along each axis, of 2 px each.
  const double r = config_.support_cells;
  const double side_px = 2.0 * 3.0 * r * r * r / (2.0 * r * r + 1.0);
  min_density_q8_ =
      static_cast<std::uint32_t>(256.0 * config_.min_support_events / (side_px * side_px) + 0.5);
  if (min_density_q8_ == 0) min_density_q8_ = 1;
}

template <void (Focus::*kStep)(int, int) noexcept>
void Focus::run_step(WorkerPool& pool) noexcept {
  pool.run([](void* self, int part, int parts) noexcept { (static_cast<Focus*>(self)->*kStep)(part, parts); },
           this);
}

CellDepth Focus::run(const Warp& warp, const HypothesisLadder& ladder, const double (&baseline_m)[3],
                     WorkerPool& pool) noexcept {
  warp_ = &warp;
  used_ = ladder.count;
  smoothing_.set_hypotheses(used_);
  for (int i = 0; i < 3; ++i) full_baseline_[i] = baseline_m[i] * ladder.step_per_m * (used_ - 1);
  run_step<&Focus::costs>(pool);
  run_step<&Focus::contrast>(pool);
  std::uint64_t contrast_sum = 0;
  for (int i = 0; i < pool.parts(); ++i) contrast_sum += sums_[i].contrast;
  const auto mean = static_cast<std::uint32_t>(contrast_sum / cells_.size());
  penalty_scale_q16_ = (kPenaltyUnit << 16) / (mean > kSmallestContrast ? mean : kSmallestContrast);
  if (config_.smoothing) {
    run_step<&Focus::penalties>(pool);
    pool.run(
        [](void* self, int part, int parts) noexcept {
          auto& focus = *static_cast<Focus*>(self);
          focus.smoothing_.along_rows(focus.penalty_, part, parts);
        },
        this);
    pool.run(
        [](void* self, int part, int parts) noexcept {
          auto& focus = *static_cast<Focus*>(self);
          focus.smoothing_.along_columns(focus.penalty_, part, parts);
        },
        this);
  }
  run_step<&Focus::decide>(pool);
  return {cells_, index_q8_, confidence_};
}

void Focus::costs(int part, int parts) noexcept {
  for (std::int32_t k = used_ * part / parts; k < used_ * (part + 1) / parts; ++k) {
    const std::size_t at = static_cast<std::size_t>(k) * cells_.size();
    plane_cost_.compute(*warp_, k, part, cost_.subspan(at, cells_.size()),
                        density_.subspan(at, cells_.size()));
  }
}

// Best cost of each cell, and the sum over cells of best minus worst.
void Focus::contrast(int part, int parts) noexcept {
  const std::size_t first = cells_.size() * static_cast<unsigned>(part) / static_cast<unsigned>(parts);
  const std::size_t last = cells_.size() * (static_cast<unsigned>(part) + 1) / static_cast<unsigned>(parts);
  std::uint64_t sum = 0;
  constexpr std::size_t kBlock = 256;
  std::uint16_t best[kBlock];
  std::uint16_t worst[kBlock];
  for (std::size_t begin = first; begin < last; begin += kBlock) {
    const std::size_t n = last - begin < kBlock ? last - begin : kBlock;
    for (std::size_t i = 0; i < n; ++i) best[i] = worst[i] = cost_[begin + i];
    for (std::int32_t k = 1; k < used_; ++k) {
      const std::uint16_t* cost = cost_.data() + static_cast<std::size_t>(k) * cells_.size() + begin;
      for (std::size_t i = 0; i < n; ++i) {
        best[i] = cost[i] > best[i] ? cost[i] : best[i];
        worst[i] = cost[i] < worst[i] ? cost[i] : worst[i];
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      best_cost_[begin + i] = best[i];
      sum += static_cast<std::uint64_t>(best[i] - worst[i]);
    }
  }
  sums_[part].contrast = sum;
}

// Cost -> penalty 0..255 relative to the cell's best, transposed so that a cell's hypotheses lie together.
void Focus::penalties(int part, int parts) noexcept {
  const std::size_t first = cells_.size() * static_cast<unsigned>(part) / static_cast<unsigned>(parts);
  const std::size_t last = cells_.size() * (static_cast<unsigned>(part) + 1) / static_cast<unsigned>(parts);
  const auto depth = static_cast<std::size_t>(used_);
  for (std::size_t cell = first; cell < last; ++cell) {
    const std::uint32_t best = best_cost_[cell];
    for (std::size_t k = 0; k < depth; ++k) {
      // 16 bits times a scale of at most 2^16: no overflow.
      const std::uint32_t p = ((best - cost_[k * cells_.size() + cell]) * penalty_scale_q16_) >> 16;
      penalty_[cell * depth + k] = static_cast<std::uint8_t>(p < 255 ? p : 255);
    }
  }
}

// Displacement in 1/16 px between the first and the last hypothesis at a cell's centre.
std::uint32_t Focus::full_parallax_q4(std::size_t cell) const noexcept {
  const auto width = static_cast<std::size_t>(cells_.width);
  const double u = 2.0 * static_cast<double>(cell % width) + 0.5;
  const double v = 2.0 * static_cast<double>(cell / width) + 0.5;
  const double px = displacement_px_m(grid_, full_baseline_, u, v);
  return px < 1000.0 ? static_cast<std::uint32_t>(px * 16.0) : 16000u;
}

void Focus::decide(int part, int parts) noexcept {
  const std::size_t first = cells_.size() * static_cast<unsigned>(part) / static_cast<unsigned>(parts);
  const std::size_t last = cells_.size() * (static_cast<unsigned>(part) + 1) / static_cast<unsigned>(parts);
  const auto depth = static_cast<std::size_t>(used_);
  std::int32_t score[64];
  for (std::size_t cell = first; cell < last; ++cell) {
    for (std::size_t k = 0; k < depth; ++k) {
      score[k] =
          config_.smoothing ? smoothing_.sums()[cell * depth + k] : 65535 - cost_[k * cells_.size() + cell];
    }
    const Peak peak = find_peak(score, used_);
    index_q8_[cell] = static_cast<std::uint16_t>(peak.index_q8);
    // Both forms in penalty units: four summed paths, or one raw cost.
    const std::uint64_t gap = config_.smoothing
                                  ? static_cast<std::uint64_t>(peak.gap) / 4
                                  : (static_cast<std::uint64_t>(peak.gap) * penalty_scale_q16_) >> 16;
    const bool supported =
        density_[static_cast<std::size_t>(peak.best) * cells_.size() + cell] >= min_density_q8_;
    // What stood out by chance where hardly anything moved is no depth: trust falls with the parallax at the
    // peak.
    const std::uint32_t full_q4 = full_parallax_q4(cell);
    const std::uint64_t parallax_q4 =
        static_cast<std::uint64_t>(full_q4) * index_q8_[cell] / (static_cast<unsigned>(used_ - 1) * 256u);
    const std::uint64_t capped = gap < 254 ? gap : 254;
    const std::uint64_t trust = capped * parallax_q4 / (parallax_q4 + kHalfTrust_q4) + 1;
    const bool known = supported && full_q4 >= kLeastParallax_q4;
    confidence_[cell] = known ? static_cast<std::uint8_t>(trust) : std::uint8_t{0};
  }
}

}  // namespace egofocus
