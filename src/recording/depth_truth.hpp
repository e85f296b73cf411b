// Depth truth of other layouts, brought onto the undistorted grid of the event camera. By nearest pixel:
// depth is never averaged across an edge.
#pragma once

#include <array>

#include "egofocus/config.hpp"
#include "recording/picture.hpp"

namespace egofocus::recording {

/// `raw_m`: depth along the optical axis on the distorted sensor pixels, as a camera sees it. Each pixel of
/// the grid takes the value of the sensor pixel that its ray falls on; 0 where there is none.
/// `raw_m` has the size of camera.intrinsics; the result has the size of `grid`.
[[nodiscard]] Picture<float> undistorted_depth(const Picture<float>& raw_m, const CameraModel& camera,
                                               const Intrinsics& grid);

/// A rectified view that shares its centre with the event camera.
struct RectifiedView {
  Intrinsics intrinsics;                                                   ///< of the rectified pictures
  std::array<double, 9> rectified_from_camera{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< rotation
  std::array<double, 16> disparity_to_depth{};  ///< OpenCV's Q: (x y disparity 1) -> homogeneous point, m
};

/// `disparity_px_256`: disparity * 256 on the rectified view, 0 unknown. The two views differ by a rotation
/// alone, so each ray of the grid meets one rectified pixel, and no pixel hides another. A rectified depth Z
/// of the ray (x, y, 1) becomes Z / z, where z is that ray's third component in the rectified view.
[[nodiscard]] Picture<float> depth_of_disparity(const Grey16Picture& disparity_px_256,
                                                const RectifiedView& view, const Intrinsics& grid);

}  // namespace egofocus::recording
