// A frame, its depth and the events around it in one picture: do they lie in one geometry?
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "egofocus/types.hpp"
#include "recording/picture.hpp"

namespace egofocus::recording {

/// Between two isolines depth changes by so much.
inline constexpr double kIsolineStep = 1.25;

/// All on the working grid. `grey` and `depth_m` are as large as it, or empty. `grid_pixel`: of each sensor
/// pixel (see grid_pixels()). The ground is `grey`, half as strong, or white; isolines of depth are green, on
/// the pixel left of or above the step, with sky and 0 (unknown) as they are in a depth picture: sky is
/// beyond all isolines, next to unknown pixels there are none; over both lie the events, ON red and OFF blue,
/// the later one where both came.
[[nodiscard]] RgbPicture overlay_picture(const Intrinsics& grid, const GreyPicture& grey,
                                         const Picture<float>& depth_m, std::span<const Event> events,
                                         std::int32_t sensor_width_px,
                                         std::span<const std::int32_t> grid_pixel);

}  // namespace egofocus::recording
