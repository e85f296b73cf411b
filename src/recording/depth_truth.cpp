#include "recording/depth_truth.hpp"

#include <cmath>

#include "pipeline/working_grid.hpp"

namespace egofocus::recording {
namespace {

/// The nearest pixel's value; `unknown` outside.
template <typename Pixel>
Pixel nearest(const Picture<Pixel>& picture, double x, double y, Pixel unknown) {
  const double column = std::floor(x + 0.5);
  const double row = std::floor(y + 0.5);
  // Written so that a NaN falls outside.
  if (!(column >= 0 && row >= 0 && column < picture.width_px && row < picture.height_px)) return unknown;
  return picture.at(static_cast<std::int32_t>(column), static_cast<std::int32_t>(row));
}

}  // namespace

Picture<float> undistorted_depth(const Picture<float>& raw_m, const CameraModel& camera,
                                 const Intrinsics& grid) {
  Picture<float> depth(grid.width_px, grid.height_px);
  const Intrinsics& in = camera.intrinsics;
  for (std::int32_t row = 0; row < grid.height_px; ++row) {
    for (std::int32_t column = 0; column < grid.width_px; ++column) {
      const double x = (column - grid.cx_px) / grid.fx_px;
      const double y = (row - grid.cy_px) / grid.fy_px;
      double distorted_x = 0;
      double distorted_y = 0;
      distort(camera, x, y, distorted_x, distorted_y);
      // Far outside its calibrated field a polynomial may fold back into the picture: the way back tells.
      double back_x = 0;
      double back_y = 0;
      if (!undistort(camera, distorted_x, distorted_y, back_x, back_y)) continue;
      const double error_px = std::abs(back_x - x) * grid.fx_px + std::abs(back_y - y) * grid.fy_px;
      if (!(error_px < 0.5)) continue;
      const float value =
          nearest(raw_m, distorted_x * in.fx_px + in.cx_px, distorted_y * in.fy_px + in.cy_px, 0.0f);
      depth.at(column, row) = std::isfinite(value) && value > 0 ? value : 0.0f;
    }
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
      const std::uint16_t raw = nearest(disparity_px_256, u, v, std::uint16_t{0});
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
