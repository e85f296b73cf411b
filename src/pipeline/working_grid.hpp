// The working grid: the undistorted pinhole picture on which everything after the sensor lives.
// Undistortion and resampling are one table from sensor pixels to rays.
#pragma once

#include <span>

#include "egofocus/config.hpp"
#include "egofocus/status.hpp"

namespace egofocus {

/// Undistorted normalised camera coordinates of a sensor pixel: the ray is (x, y, 1).
/// A pixel that the distortion model cannot reach has x = y = kNoRay, far outside any grid.
struct Ray {
  float x = 0;
  float y = 0;
};
inline constexpr float kNoRay = 1e6f;

/// The grid that a configuration means: the stated one, or the camera's own pinhole part.
Intrinsics working_grid(const Config& config) noexcept;

/// Normalised undistorted -> normalised distorted coordinates (plumb-bob: OpenCV's order k1 k2 p1 p2 k3;
/// equidistant: theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)).
/// Thread: any. RT: yes.
void distort(const CameraModel& camera, double x, double y, double& x_out, double& y_out) noexcept;

/// The inverse, by Newton steps on the radius (equidistant) or fixed-point steps (plumb-bob).
/// False when it does not come back to the input within 0.05 px. Thread: any. RT: no (set-up).
bool undistort(const CameraModel& camera, double x, double y, double& x_out, double& y_out) noexcept;

/// Sizes, focal lengths and centre of both pictures, and that the distortion can be inverted along the border
/// and on the diagonals. RT: no (set-up).
Status check_camera(const Config& config) noexcept;

/// Fills rays[y * width + x] for every sensor pixel. RT: no (set-up).
void fill_rays(const CameraModel& camera, std::span<Ray> rays) noexcept;

}  // namespace egofocus
