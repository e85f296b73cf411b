#include "pipeline/hypothesis_ladder.hpp"

#include "core/elementary.hpp"

namespace egofocus {
namespace {

// Mean of (c - c_z x)^2 over x uniform on the pixel centres of one axis, in px^2 at 1 m.
double mean_square_px2(double c, double c_z, double focal_px, double centre_px,
                       std::int32_t size_px) noexcept {
  const double middle = 0.5 * (size_px - 1) - centre_px;
  const double spread = (static_cast<double>(size_px) * size_px - 1.0) / 12.0;
  const double a = focal_px * c;
  return a * a - 2.0 * a * c_z * middle + c_z * c_z * (middle * middle + spread);
}

}  // namespace

double rms_displacement_px_m(const Intrinsics& grid, const double centre_m[3]) noexcept {
  return square_root(mean_square_px2(centre_m[0], centre_m[2], grid.fx_px, grid.cx_px, grid.width_px) +
                     mean_square_px2(centre_m[1], centre_m[2], grid.fy_px, grid.cy_px, grid.height_px));
}

double displacement_px_m(const Intrinsics& grid, const double centre_m[3], double u_px,
                         double v_px) noexcept {
  const double du = grid.fx_px * centre_m[0] - centre_m[2] * (u_px - grid.cx_px);
  const double dv = grid.fy_px * centre_m[1] - centre_m[2] * (v_px - grid.cy_px);
  return square_root(du * du + dv * dv);
}

Status check_ladder(const LadderConfig& config) noexcept {
  if (config.hypotheses < 8 || config.hypotheses > 64 || config.hypotheses % 8 != 0) {
    return {StatusCode::kBadLadder, "ladder.hypotheses", config.hypotheses, 64};
  }
  if (!(config.z_near_m >= 0.02 && config.z_near_m <= 100))
    return {StatusCode::kBadLadder, "ladder.z_near_m"};
  if (!(config.span_px >= 2 && config.span_px <= 200)) return {StatusCode::kBadLadder, "ladder.span_px"};
  if (!(config.min_parallax_px >= 0 && config.min_parallax_px <= config.span_px)) {
    return {StatusCode::kBadLadder, "ladder.min_parallax_px"};
  }
  return {};
}

HypothesisLadder choose_ladder(const LadderConfig& config, const Intrinsics& grid,
                               const MotionTrack& longest) noexcept {
  const bool parallax_ladder = config.kind == LadderKind::kParallax;
  const double limit_px_m = parallax_ladder ? config.span_px * config.z_near_m : 1e300;
  // The largest displacement inside the window counts: a shaking camera may be back where it began.
  double largest_px_m = 0;
  int oldest = MotionTrack::kKnots - 1;
  for (int i = MotionTrack::kKnots - 2; i >= 0; --i) {
    const double displacement = rms_displacement_px_m(grid, longest.knots[i].centre_m);
    if (displacement > limit_px_m) break;
    if (displacement > largest_px_m) largest_px_m = displacement;
    oldest = i;
  }
  HypothesisLadder ladder;
  const std::int64_t length_us = longest.end_us - longest.begin_us;
  ladder.begin_us = longest.begin_us + length_us * oldest / (MotionTrack::kKnots - 1);
  ladder.has_parallax = largest_px_m > 0 && largest_px_m >= config.min_parallax_px * config.z_near_m;
  if (!ladder.has_parallax) return ladder;
  const double rho_max = parallax_ladder ? config.span_px / largest_px_m : 1.0 / config.z_near_m;
  ladder.step_per_m = rho_max / (config.hypotheses - 1);
  // One hypothesis beyond z_near, so that a peak there has neighbours on both sides; whole vectors of 8.
  const double needed = floor_of(1.0 / (config.z_near_m * ladder.step_per_m)) + 3.0;
  const std::int32_t whole = needed < 64.0 ? (static_cast<std::int32_t>(needed) + 7) / 8 * 8 : 64;
  ladder.count = whole < config.hypotheses ? whole : config.hypotheses;
  ladder.parallax_px = ladder.step_per_m * (ladder.count - 1) * largest_px_m;
  return ladder;
}

}  // namespace egofocus
