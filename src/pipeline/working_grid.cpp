#include "pipeline/working_grid.hpp"

#include "core/elementary.hpp"

namespace egofocus {
namespace {

constexpr double kHalfPi = 1.57079632679489661923;

double radial(const double* k, double r2) noexcept {
  return 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
}

double equidistant_angle(const double* k, double theta) noexcept {
  const double t2 = theta * theta;
  return theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

Status check_pinhole(const Intrinsics& in, const char* size, const char* focal, const char* centre) noexcept {
  if (in.width_px < 8 || in.width_px > 1280) return {StatusCode::kBadResolution, size, in.width_px, 1280};
  if (in.height_px < 8 || in.height_px > 1280) return {StatusCode::kBadResolution, size, in.height_px, 1280};
  // A focal length outside these bounds belongs to another picture size (fields of view of 2 to 160 degrees).
  const double smallest = 0.08 * in.width_px;
  const double largest = 30.0 * in.width_px;
  for (const double f : {in.fx_px, in.fy_px}) {
    if (!(f >= smallest && f <= largest)) return {StatusCode::kBadIntrinsics, focal, status_value(f)};
  }
  const bool inside = in.cx_px >= 0 && in.cx_px <= in.width_px && in.cy_px >= 0 && in.cy_px <= in.height_px;
  if (!inside) return {StatusCode::kBadIntrinsics, centre, status_value(in.cx_px)};
  return {};
}

}  // namespace

Intrinsics working_grid(const Config& config) noexcept {
  return config.grid.width_px != 0 ? config.grid : config.camera.intrinsics;
}

void distort(const CameraModel& camera, double x, double y, double& x_out, double& y_out) noexcept {
  const double* k = camera.coefficients;
  const double r2 = x * x + y * y;
  if (camera.distortion == Distortion::kPlumbBob) {
    const double scale = radial(k, r2);
    x_out = x * scale + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x);
    y_out = y * scale + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y;
  } else if (camera.distortion == Distortion::kEquidistant) {
    const double r = square_root(r2);
    const double scale = r < 1e-12 ? 1.0 : equidistant_angle(k, arc_tangent(r)) / r;
    x_out = x * scale;
    y_out = y * scale;
  } else {
    x_out = x;
    y_out = y;
  }
}

bool undistort(const CameraModel& camera, double x, double y, double& x_out, double& y_out) noexcept {
  const double* k = camera.coefficients;
  double u = x;
  double v = y;
  if (camera.distortion == Distortion::kPlumbBob) {
    for (int i = 0; i < 60; ++i) {
      const double r2 = u * u + v * v;
      const double scale = radial(k, r2);
      if (!(scale > 0.05)) return false;
      const double last_u = u;
      const double last_v = v;
      u = (x - 2.0 * k[2] * u * v - k[3] * (r2 + 2.0 * u * u)) / scale;
      v = (y - k[2] * (r2 + 2.0 * v * v) - 2.0 * k[3] * u * v) / scale;
      if (u == last_u && v == last_v) break;  // no further step changes anything
    }
  } else if (camera.distortion == Distortion::kEquidistant) {
    const double target = square_root(x * x + y * y);
    double theta = target < kHalfPi ? target : kHalfPi;
    for (int i = 0; i < 60; ++i) {
      const double h = 1e-6;
      const double slope = (equidistant_angle(k, theta + h) - equidistant_angle(k, theta - h)) / (2.0 * h);
      if (!(slope > 0.01)) return false;
      const double step = (equidistant_angle(k, theta) - target) / slope;
      theta -= step;
      if (step == 0) break;
    }
    // A ray at or beyond 90 degrees has no place on a pinhole grid.
    if (!(theta >= 0 && theta < 0.98 * kHalfPi)) return false;
    const double scale = target < 1e-12 ? 1.0 : tangent(theta) / target;
    u = x * scale;
    v = y * scale;
  }
  double back_x = 0;
  double back_y = 0;
  distort(camera, u, v, back_x, back_y);
  const double error_px = camera.intrinsics.fx_px * (absolute(back_x - x) + absolute(back_y - y));
  if (!(error_px < 0.05)) return false;
  x_out = u;
  y_out = v;
  return true;
}

Status check_camera(const Config& config) noexcept {
  const Intrinsics& in = config.camera.intrinsics;
  if (Status s = check_pinhole(in, "camera size", "camera focal length", "camera centre"); !s.ok()) return s;
  if (Status s = check_pinhole(working_grid(config), "grid size", "grid focal length", "grid centre");
      !s.ok())
    return s;
  if (config.camera.distortion == Distortion::kNone) return {};
  // Equidistant optics may see more than a pinhole can show: there, missing rays at the rim are no error.
  if (config.camera.distortion == Distortion::kEquidistant) {
    double x = 0;
    double y = 0;
    for (const double share : {0.25, 0.5}) {
      const double along = share * 0.5 * in.width_px / in.fx_px;
      if (!undistort(config.camera, along, 0, x, y))
        return {StatusCode::kBadDistortion, "equidistant coefficients"};
    }
    return {};
  }
  for (int i = 0; i <= 32; ++i) {
    const double along = i / 32.0;
    const double column = along * (in.width_px - 1);
    const double row = along * (in.height_px - 1);
    const double points[6][2] = {{column, 0.0}, {column, in.height_px - 1.0},
                                 {0.0, row},    {in.width_px - 1.0, row},
                                 {column, row}, {column, in.height_px - 1.0 - row}};
    for (const auto& p : points) {
      double x = 0;
      double y = 0;
      if (!undistort(config.camera, (p[0] - in.cx_px) / in.fx_px, (p[1] - in.cy_px) / in.fy_px, x, y)) {
        return {StatusCode::kBadDistortion, "pixel column where it fails", static_cast<std::int64_t>(p[0])};
      }
    }
  }
  return {};
}

void fill_rays(const CameraModel& camera, std::span<Ray> rays) noexcept {
  const Intrinsics& in = camera.intrinsics;
  std::size_t i = 0;
  for (std::int32_t row = 0; row < in.height_px; ++row) {
    for (std::int32_t column = 0; column < in.width_px; ++column, ++i) {
      double x = 0;
      double y = 0;
      const bool found = undistort(camera, (column - in.cx_px) / in.fx_px, (row - in.cy_px) / in.fy_px, x, y);
      rays[i] = found ? Ray{static_cast<float>(x), static_cast<float>(y)} : Ray{kNoRay, kNoRay};
    }
  }
}

}  // namespace egofocus
