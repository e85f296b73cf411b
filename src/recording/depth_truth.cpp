#include "recording/depth_truth.hpp"

#include <cmath>

#include "pipeline/working_grid.hpp"

namespace egofocus::recording {
namespace {

constexpr std::size_t kOutside = SIZE_MAX;

/// Index of the nearest pixel in a picture of this size, or kOutside. Written so that a NaN falls outside.
std::size_t nearest(const Intrinsics& size, double x, double y) {
  const double column = std::floor(x + 0.5);
  const double row = std::floor(y + 0.5);
  if (!(column >= 0 && row >= 0 && column < size.width_px && row < size.height_px)) return kOutside;
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(size.width_px) +
         static_cast<std::size_t>(column);
}

/// The sensor pixel that the ray (x, y, 1) falls on.
std::size_t sensor_pixel(const CameraModel& camera, const Intrinsics& grid, double x, double y) {
  double distorted_x = 0;
  double distorted_y = 0;
  distort(camera, x, y, distorted_x, distorted_y);
  // Far outside its calibrated field a polynomial may fold back into the picture: the way back tells.
  double back_x = 0;
  double back_y = 0;
  if (!undistort(camera, distorted_x, distorted_y, back_x, back_y)) return kOutside;
  const double error_px = std::abs(back_x - x) * grid.fx_px + std::abs(back_y - y) * grid.fy_px;
  if (!(error_px < 0.5)) return kOutside;
  const Intrinsics& in = camera.intrinsics;
  return nearest(in, distorted_x * in.fx_px + in.cx_px, distorted_y * in.fy_px + in.cy_px);
}

}  // namespace

Undistortion::Undistortion(const CameraModel& camera, const Intrinsics& grid) : grid_(grid) {
  for (std::int32_t row = 0; row < grid.height_px; ++row) {
    for (std::int32_t column = 0; column < grid.width_px; ++column) {
      source_.push_back(
          sensor_pixel(camera, grid, (column - grid.cx_px) / grid.fx_px, (row - grid.cy_px) / grid.fy_px));
    }
  }
}

Picture<float> Undistortion::depth(const Picture<float>& raw_m) const {
  Picture<float> depth(grid_.width_px, grid_.height_px);
  for (std::size_t i = 0; i < source_.size(); ++i) {
    if (source_[i] == kOutside) continue;
    const float value = raw_m.pixels[source_[i]];
    if (std::isfinite(value) && value > 0) depth.pixels[i] = value;
  }
  return depth;
}

Picture<float> depth_of_disparity(const Grey16Picture& disparity_px_256, const RectifiedView& view,
                                  const Intrinsics& grid) {
  Picture<float> depth(grid.width_px, grid.height_px);
  const std::array<double, 9>& r = view.rectified_from_camera;
  const std::array<double, 16>& q = view.disparity_to_depth;
  for (std::int32_t row = 0; row < grid.height_px; ++row) {
    for (std::int32_t column = 0; column < grid.width_px; ++column) {
      const double x = (column - grid.cx_px) / grid.fx_px;
      const double y = (row - grid.cy_px) / grid.fy_px;
      const double z = r[6] * x + r[7] * y + r[8];
      if (!(z > 0)) continue;
      const double u = (r[0] * x + r[1] * y + r[2]) / z * view.intrinsics.fx_px + view.intrinsics.cx_px;
      const double v = (r[3] * x + r[4] * y + r[5]) / z * view.intrinsics.fy_px + view.intrinsics.cy_px;
      const std::size_t source = nearest(view.intrinsics, u, v);
      const std::uint16_t raw = source == kOutside ? std::uint16_t{0} : disparity_px_256.pixels[source];
      if (raw == 0) continue;
      const double disparity = raw / 256.0;
      const double rectified_m = (q[8] * u + q[9] * v + q[10] * disparity + q[11]) /
                                 (q[12] * u + q[13] * v + q[14] * disparity + q[15]);
      const double metres = rectified_m / z;
      if (std::isfinite(metres) && metres > 0) depth.at(column, row) = static_cast<float>(metres);
    }
  }
  return depth;
}

}  // namespace egofocus::recording
