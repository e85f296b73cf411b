// Which inverse depths a tick tries, and how far back its window reaches (METHOD, section 1, "Window",
// "Hypotheses").
#pragma once

#include "egofocus/config.hpp"
#include "egofocus/status.hpp"
#include "pipeline/motion_track.hpp"

namespace egofocus {

/// rho_k = k * step_per_m for k < count. In slow motion a parallax ladder reaches far nearer than z_near:
/// those hypotheses are left out, so count is a multiple of 8 that may be below the configured number.
struct HypothesisLadder {
  std::int64_t begin_us = 0;  ///< the window's oldest time
  std::int32_t count = 0;
  double step_per_m = 0;   ///< 1/m
  double parallax_px = 0;  ///< rms displacement over the grid at hypothesis count - 1, between begin and end
  bool has_parallax = false;  ///< the displacement at z_near reaches the configured minimum
};

/// Root mean square over the grid of the displacement, in px, of points at 1 m when the camera's centre lies
/// at `centre_m` in the reference view: f (c_x - c_z x), f (c_y - c_z y). Thread: any. RT: yes.
double rms_displacement_px_m(const Intrinsics& grid, const double centre_m[3]) noexcept;

/// The same at one point of the grid: the displacement of what lands on (u, v). Thread: any. RT: yes.
double displacement_px_m(const Intrinsics& grid, const double centre_m[3], double u_px, double v_px) noexcept;

Status check_ladder(const LadderConfig& config) noexcept;

/// `longest` covers the longest window allowed. kParallax cuts it where a point at z_near would leave the
/// ladder. Thread: the tick. RT: yes.
HypothesisLadder choose_ladder(const LadderConfig& config, const Intrinsics& grid,
                               const MotionTrack& longest) noexcept;

}  // namespace egofocus
