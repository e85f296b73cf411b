#include "pipeline/focus_input.hpp"

#include "core/check.hpp"
#include "core/elementary.hpp"
#include "pipeline/fixed_point.hpp"
#include "pipeline/in_parts.hpp"

namespace egofocus {
namespace {

constexpr double kMostShift_q8 = 32767;

// Half away from zero, saturating; a displacement that is no number is none.
std::int32_t shift_q8(double px) noexcept {
  const double size = absolute(px) * 256.0;
  if (!(size >= 0)) return 0;
  const auto rounded =
      static_cast<std::int32_t>(floor_of((size < kMostShift_q8 ? size : kMostShift_q8) + 0.5));
  return px < 0 ? -rounded : rounded;
}

std::uint8_t shift_byte(std::int32_t value_q8) noexcept {
  return input_byte(static_cast<std::uint32_t>((value_q8 < 0 ? -value_q8 : value_q8) + 4) >> 3, value_q8 < 0);
}

}  // namespace

Status FocusInput::check(const FocusInputConfig& config) noexcept {
  if (config.map_count < 1 || config.map_count > FocusInputConfig::kMostMaps)
    return {StatusCode::kBadFocus, "focus input: number of maps (1..8)", config.map_count,
            FocusInputConfig::kMostMaps};
  for (std::int32_t m = 0; m < config.map_count; ++m) {
    const FocusMap& map = config.maps[m];
    if (map.kind > FocusMapKind::kSquares)
      return {StatusCode::kBadFocus, "focus input: map (FocusMapKind)", static_cast<std::int64_t>(map.kind)};
    if (map.side < 1 || map.side > 7 || map.side % 2 == 0)
      return {StatusCode::kBadFocus, "focus input: side of a support (1, 3, 5, 7)", map.side, 7};
  }
  if (config.floor_events_milli < 20 || config.floor_events_milli > 2000)
    return {StatusCode::kBadFocus, "focus input: floor_events (0.02..2), in thousandths",
            config.floor_events_milli, 2000};
  if (config.floor_noise_milli < 100 || config.floor_noise_milli > 8000)
    return {StatusCode::kBadFocus, "focus input: floor_noise (0.1..8), in thousandths",
            config.floor_noise_milli, 8000};
  return {};
}

std::size_t FocusInput::sums_bytes(const Intrinsics& grid, std::int32_t hypotheses) noexcept {
  return sizeof(std::uint16_t) * 4 * static_cast<std::size_t>(hypotheses) *
         energy_grid(grid.width_px, grid.height_px).size();
}

std::size_t FocusInput::focus_bytes(const FocusInputConfig& config, const Intrinsics& grid,
                                    std::int32_t hypotheses) noexcept {
  return static_cast<std::size_t>(hypotheses) * static_cast<std::size_t>(config.map_count) *
         energy_grid(grid.width_px, grid.height_px).size();
}

std::size_t FocusInput::context_bytes(const FocusInputConfig& config, const Intrinsics& grid) noexcept {
  return static_cast<std::size_t>(config.map_count + 6) * energy_grid(grid.width_px, grid.height_px).size();
}

std::size_t FocusInput::rows_bytes(const Intrinsics& grid, std::int32_t hypotheses, int parts) noexcept {
  Arena counter;
  Scratch s;
  const auto width = static_cast<std::size_t>(energy_grid(grid.width_px, grid.height_px).width);
  for (int i = 0; i < parts; ++i)
    take_rows(s, static_cast<std::size_t>(hypotheses), padded_row(width), counter);
  return counter.used_bytes();
}

void FocusInput::take_rows(Scratch& s, std::size_t depth, std::size_t padded, Arena& arena) noexcept {
  s.counts = arena.array<std::uint32_t>(depth * padded);
  s.reciprocal = arena.array<std::uint32_t>(depth * padded);
  s.ratio = arena.array<std::uint32_t>(depth * padded);
  s.line = arena.array<std::uint32_t>(2 * (padded + 6));
  s.count_sum = arena.array<std::uint32_t>(padded);
  s.deviation = arena.array<std::int16_t>(depth * padded);
  for (std::span<std::uint32_t>* values :
       {&s.row.mean, &s.row.half, &s.row.scale, &s.row.square, &s.row.noise})
    *values = arena.array<std::uint32_t>(padded);
  s.row.low = arena.array<std::int32_t>(padded);
  s.row.high = arena.array<std::int32_t>(padded);
  s.row.limit = arena.array<std::int16_t>(padded);
  s.row.factor = arena.array<std::uint16_t>(padded);
  s.row.gain = arena.array<std::uint16_t>(padded);
}

FocusInput::FocusInput(const FocusInputConfig& config, const Intrinsics& grid, std::int32_t hypotheses,
                       int parts, const Memory& memory) noexcept
    : config_(config),
      grid_(grid),
      cells_(energy_grid(grid.width_px, grid.height_px)),
      hypotheses_(hypotheses),
      floor_noise_q20_(static_cast<std::uint32_t>(
          ((static_cast<std::int64_t>(config.floor_noise_milli) << 20) + 500) / 1000)) {
  EGOFOCUS_CHECK(hypotheses >= 1 && hypotheses <= kMostHypotheses);
  const auto depth = static_cast<std::size_t>(hypotheses);
  const auto width = static_cast<std::size_t>(cells_.width);
  const std::size_t padded = padded_row(width);
  for (std::int32_t i = 0; i < 4; ++i) scale_[i] = support_scale(2 * i + 1, config.floor_events_milli);
  for (std::int32_t m = 0; m < config.map_count; ++m) {
    const FocusMapKind kind = config.maps[m].kind;
    has_direction_ |= kind == FocusMapKind::kGradientX || kind == FocusMapKind::kGradientY;
  }
  sums_ = memory.sums.array<std::uint16_t>(sums_bytes(grid, hypotheses) / sizeof(std::uint16_t));
  focus_ = memory.focus.array<std::uint8_t>(focus_bytes(config, grid, hypotheses));
  context_ = memory.context.array<std::uint8_t>(context_bytes(config, grid));
  column_q8_ = memory.always.array<std::int32_t>(width);
  row_q8_ = memory.always.array<std::int32_t>(static_cast<std::size_t>(cells_.height));
  for (int i = 0; i < parts; ++i) {
    scratch_[i].strip = memory.always.array<std::uint32_t>(4 * static_cast<std::size_t>(grid.width_px));
    take_rows(scratch_[i], depth, padded, memory.rows);
  }
}

void FocusInput::run(std::span<const std::uint8_t> planes, const HypothesisLadder& ladder,
                     const double (&baseline_m)[3], WorkerPool& pool) noexcept {
  begin(ladder, baseline_m);
  const auto pixels = static_cast<std::size_t>(grid_.width_px) * static_cast<std::size_t>(grid_.height_px);
  in_parts(pool, [&](int part, int parts) noexcept {
    for (std::int32_t k = used_ * part / parts; k < used_ * (part + 1) / parts; ++k)
      add_plane(k, planes.subspan(static_cast<std::size_t>(k) * pixels, pixels), part);
  });
  finish(pool);
}

void FocusInput::begin(const HypothesisLadder& ladder, const double (&baseline_m)[3]) noexcept {
  EGOFOCUS_CHECK(ladder.count >= 1 && ladder.count <= hypotheses_);
  used_ = ladder.count;
  displacements(ladder, baseline_m);
}

void FocusInput::add_plane(std::int32_t k, std::span<const std::uint8_t> plane, int part) noexcept {
  sum_cells(plane, grid_.width_px, grid_.height_px, scratch_[part].strip,
            {sums(0, k), sums(1, k), sums(2, k), sums(3, k)});
  adds_second_[static_cast<std::size_t>(k)] = has_direction_ || gather(sums(0, k), sums(1, k));
}

void FocusInput::finish(WorkerPool& pool) noexcept {
  in_parts(pool, [this](int part, int parts) noexcept { rows(part, parts); });
}

// Where a cell's centre moves with one hypothesis more: its x depends on the column alone, its y on the row.
void FocusInput::displacements(const HypothesisLadder& ladder, const double (&baseline_m)[3]) noexcept {
  const double x = baseline_m[0] * ladder.step_per_m;
  const double y = baseline_m[1] * ladder.step_per_m;
  const double z = baseline_m[2] * ladder.step_per_m;
  for (std::int32_t i = 0; i < cells_.width; ++i)
    column_q8_[static_cast<std::size_t>(i)] = shift_q8(grid_.fx_px * x - z * ((4 * i + 1.5) - grid_.cx_px));
  for (std::int32_t i = 0; i < cells_.height; ++i)
    row_q8_[static_cast<std::size_t>(i)] = shift_q8(grid_.fy_px * y - z * ((4 * i + 1.5) - grid_.cy_px));
}

std::span<std::uint16_t> FocusInput::sums(std::size_t map, std::int32_t k) const noexcept {
  const std::size_t plane = 4 * static_cast<std::size_t>(k) + map;
  return sums_.subspan(plane * cells_.size(), cells_.size());
}

bool FocusInput::has_map(std::int32_t side) const noexcept {
  for (std::int32_t m = 0; m < config_.map_count; ++m)
    if (config_.maps[m].side == side) return true;
  return false;
}

void FocusInput::rows(int part, int parts) noexcept {
  Scratch& s = scratch_[part];
  const auto width = static_cast<std::size_t>(cells_.width);
  const auto maps = static_cast<std::size_t>(config_.map_count);
  const std::int32_t end = cells_.height * (part + 1) / parts;
  for (std::int32_t y = cells_.height * part / parts; y < end; ++y) {
    for (const std::int32_t side : {1, 3, 5, 7}) {
      if (side == 1 || side == 7 || has_map(side)) support(side, y, s);
    }
    parallax(y);
    const std::size_t at = static_cast<std::size_t>(y) * width;
    for (std::size_t plane = static_cast<std::size_t>(used_) * maps;
         plane < static_cast<std::size_t>(hypotheses_) * maps; ++plane)
      for (std::uint8_t& z : focus_.subspan(plane * cells_.size() + at, width)) z = kInputZero;
  }
}

// All that rests on the support of one side, in row y.
void FocusInput::support(std::int32_t side, std::int32_t y, Scratch& s) noexcept {
  const SupportScale& scale = scale_[side / 2];
  const auto width = static_cast<std::size_t>(cells_.width);
  const std::size_t padded = s.count_sum.size();
  const auto stride = static_cast<std::int32_t>(padded);
  const std::size_t at = static_cast<std::size_t>(y) * width;
  const std::span<std::uint32_t> counts = s.counts.first(static_cast<std::size_t>(used_) * padded);
  const std::span<std::uint32_t> ratio = s.ratio.first(counts.size());
  support_row(sums(3, 0).data(), nullptr, {}, used_, 4 * cells_.size(), cells_, side, y, s.line, stride,
              counts.data());
  for (std::uint32_t& sum : s.count_sum) sum = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(used_); ++k)
    for (std::size_t x = 0; x < padded; ++x) s.count_sum[x] += counts[k * padded + x];
  if (side == 1 || side == 7)
    density_row(scale, s.count_sum.first(width), used_, &context_[(side == 1 ? 0 : cells_.size()) + at]);
  if (!has_map(side)) return;
  reciprocals(scale, counts, s.reciprocal.data());
  noise_row(scale, s.count_sum, used_, s.row.noise);
  const auto maps = static_cast<std::size_t>(config_.map_count);
  for (std::size_t m = 0; m < maps; ++m) {
    if (config_.maps[m].side != side) continue;
    const FocusMapKind kind = config_.maps[m].kind;
    const std::size_t first = kind == FocusMapKind::kSquares ? 2 : (kind == FocusMapKind::kGradientY ? 1 : 0);
    const std::uint16_t* const second = kind == FocusMapKind::kGradient ? sums(1, 0).data() : nullptr;
    support_row(sums(first, 0).data(), second, adds_second_, used_, 4 * cells_.size(), cells_, side, y,
                s.line, stride, ratio.data());
    sharpness_row(scale, floor_noise_q20_, used_, s.reciprocal.first(ratio.size()), ratio, s.deviation, s.row,
                  width, &focus_[m * cells_.size() + at], maps * cells_.size(),
                  &context_[(2 + m) * cells_.size() + at]);
  }
}

void FocusInput::parallax(std::int32_t y) noexcept {
  const auto width = static_cast<std::size_t>(cells_.width);
  std::uint8_t* to = &context_[static_cast<std::size_t>(2 + config_.map_count) * cells_.size() +
                               static_cast<std::size_t>(y) * width];
  const std::int32_t dy = row_q8_[static_cast<std::size_t>(y)];
  const std::int32_t share = (64 * used_ + hypotheses_) / (2 * hypotheses_);  // 32 K / D, half up
  for (std::size_t x = 0; x < width; ++x) {
    const std::int32_t dx = column_q8_[x];
    const auto norm_q8 = floor_square_root_u32(static_cast<std::uint32_t>(dx * dx + dy * dy));
    to[x] = shift_byte(dx);
    to[cells_.size() + x] = shift_byte(dy);
    to[2 * cells_.size() + x] = shift_byte(static_cast<std::int32_t>(norm_q8));
    to[3 * cells_.size() + x] = static_cast<std::uint8_t>(kInputZero + share);
  }
}

}  // namespace egofocus
