// Depth truth of other layouts, brought onto the undistorted grid of the event camera. By nearest pixel:
// depth is never averaged across an edge.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "egofocus/config.hpp"
#include "recording/picture.hpp"

namespace egofocus::recording {

/// From the distorted sensor pixels to the grid; the way is found once, for all pictures of a camera.
class Undistortion {
 public:
  Undistortion(const CameraModel& camera, const Intrinsics& grid);

  /// `raw_m`: depth along the optical axis on the sensor pixels, of the camera's size; not finite or <= 0 is
  /// unknown. Each pixel of the grid takes the value of the sensor pixel that its ray falls on, or 0.
  [[nodiscard]] Picture<float> depth(const Picture<float>& raw_m) const;

 private:
  Intrinsics grid_;
  std::vector<std::size_t> source_;  // of each grid pixel: index of its sensor pixel; SIZE_MAX: none
};

/// A rectified view that shares its centre with the event camera.
struct RectifiedView {
  Intrinsics intrinsics;                                                   ///< of the rectified pictures
  std::array<double, 9> rectified_from_camera{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< rotation
  std::array<double, 16> disparity_to_depth{};  ///< OpenCV's Q: (x y disparity 1) -> homogeneous point, m
};

/// `disparity_px_256`: disparity * 256 on the rectified view and of its size, 0 unknown. The two views differ
/// by a rotation alone, so each ray of the grid meets one rectified pixel, and no pixel hides another. A
/// rectified depth Z of the ray (x, y, 1) becomes Z / z, where z is that ray's third component in the
/// rectified view.
[[nodiscard]] Picture<float> depth_of_disparity(const Grey16Picture& disparity_px_256,
                                                const RectifiedView& view, const Intrinsics& grid);

}  // namespace egofocus::recording
