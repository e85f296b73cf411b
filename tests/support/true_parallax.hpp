// How far a still point really moves across the picture while a window lasts: from poses and depth alone.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "egofocus/config.hpp"

namespace egofocus::sim {

/// Centre of the camera at `then_us` in the camera's frame at `now_us`, in metres. Both are times of poses.
struct CentreShift {
  double x = 0;
  double y = 0;
  double z = 0;
};
CentreShift centre_shift(std::span<const PoseSample> poses, std::int64_t then_us, std::int64_t now_us);

/// Parallax of each pixel of the grid, in px, against a point at infinity: |f (c_xy - c_z x)| / depth, where
/// depth is known (above 0); else 0.
std::vector<double> parallax_px(const CentreShift& shift, const Intrinsics& grid,
                                std::span<const float> depth_m);

/// Begin of the window that the parallax ladder takes for a tick, to the next pose: as old as allowed, while
/// the rms parallax at z_near stays within the span.
std::int64_t window_begin_us(std::span<const PoseSample> poses, const Config& config, std::int64_t tick_us);

}  // namespace egofocus::sim
