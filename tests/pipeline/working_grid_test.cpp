// The working grid against the two distortion models written down again over libm, in long double.
#include "pipeline/working_grid.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

using namespace egofocus;

namespace {

using Real = long double;

CameraModel davis240() {
  CameraModel camera;
  camera.intrinsics = {240, 180, 335, 335, 129.9, 99.2};
  camera.distortion = Distortion::kPlumbBob;
  const double k[5] = {-0.1386, 0.0934, -0.0003, 0.0002, 0};
  for (int i = 0; i < 5; ++i) camera.coefficients[i] = k[i];
  return camera;
}

CameraModel mvsec_like() {
  CameraModel camera;
  camera.intrinsics = {346, 260, 226, 226, 173, 133};
  camera.distortion = Distortion::kEquidistant;
  const double k[5] = {-0.048, 0.011, -0.055, 0.021, 0};
  for (int i = 0; i < 5; ++i) camera.coefficients[i] = k[i];
  return camera;
}

struct Point {
  Real x, y;
};

// OpenCV's documented plumb-bob model, and Kannala-Brandt's equidistant one.
Point distorted(const CameraModel& camera, Real x, Real y) {
  const double* k = camera.coefficients;
  const Real r = std::hypot(x, y);
  if (camera.distortion == Distortion::kPlumbBob) {
    const Real scale =
        1 + k[0] * std::pow(r, Real(2)) + k[1] * std::pow(r, Real(4)) + k[4] * std::pow(r, Real(6));
    return {x * scale + 2 * k[2] * x * y + k[3] * (r * r + 2 * x * x),
            y * scale + k[2] * (r * r + 2 * y * y) + 2 * k[3] * x * y};
  }
  const Real theta = std::atan(r);
  Real bent = theta;
  for (int i = 0; i < 4; ++i) bent += k[i] * std::pow(theta, Real(2 * i + 3));
  return r == 0 ? Point{x, y} : Point{x * bent / r, y * bent / r};
}

void check_round_trip(const CameraModel& camera) {
  const Intrinsics& in = camera.intrinsics;
  Real worst_forward = 0;
  Real worst_back_px = 0;
  int missing = 0;
  for (int row = 0; row < in.height_px; row += 7) {
    for (int column = 0; column < in.width_px; column += 7) {
      const double x = (column - in.cx_px) / in.fx_px;
      const double y = (row - in.cy_px) / in.fy_px;
      double u = 0;
      double v = 0;
      if (!undistort(camera, x, y, u, v)) {
        ++missing;
        continue;
      }
      double back_x = 0;
      double back_y = 0;
      distort(camera, u, v, back_x, back_y);
      const Point truth = distorted(camera, u, v);
      worst_forward = std::max(worst_forward, std::hypot(back_x - truth.x, back_y - truth.y));
      worst_back_px = std::max(worst_back_px, in.fx_px * std::hypot(truth.x - x, truth.y - y));
    }
  }
  WARN("worst error: distort " << static_cast<double>(worst_forward) << ", undistort "
                               << static_cast<double>(worst_back_px) << " px");
  CHECK(missing == 0);
  CHECK(worst_forward < 1e-13);
  CHECK(worst_back_px < 1e-6);
}

}  // namespace

TEST_CASE("plumb-bob: what is undistorted comes back under libm's own model") {
  check_round_trip(davis240());
}

TEST_CASE("equidistant: what is undistorted comes back under libm's own model") {
  check_round_trip(mvsec_like());
}

TEST_CASE("the ray table holds one ray per sensor pixel, and none where there is none", "[long]") {
  const CameraModel camera = davis240();
  std::vector<Ray> rays(240 * 180);
  fill_rays(camera, rays);
  for (int i : {0, 239, 17 * 240 + 101, 179 * 240, 179 * 240 + 239}) {
    const Point back = distorted(camera, static_cast<Real>(rays[static_cast<std::size_t>(i)].x),
                                 static_cast<Real>(rays[static_cast<std::size_t>(i)].y));
    CHECK(static_cast<double>(back.x * 335 + Real(129.9)) == Approx(i % 240).margin(1e-4));
    CHECK(static_cast<double>(back.y * 335 + Real(99.2)) == Approx(i / 240).margin(1e-4));
  }
  // A fisheye of 226 px sees 90 degrees off axis at about 226 * 1.4 px: the corner of a wide chip is beyond.
  CameraModel wide = mvsec_like();
  wide.intrinsics = {1000, 1000, 226, 226, 500, 500};
  std::vector<Ray> wide_rays(1000 * 1000);
  fill_rays(wide, wide_rays);
  CHECK(wide_rays[0].x == kNoRay);
  CHECK(wide_rays[0].y == kNoRay);
  CHECK(std::abs(wide_rays[500 * 1000 + 500].x) < 1e-6f);
}

TEST_CASE("without distortion a ray is the pinhole's") {
  CameraModel camera = davis240();
  camera.distortion = Distortion::kNone;
  std::vector<Ray> rays(240 * 180);
  fill_rays(camera, rays);
  CHECK(static_cast<double>(rays[50 * 240 + 20].x) == Approx((20 - 129.9) / 335));
  CHECK(static_cast<double>(rays[50 * 240 + 20].y) == Approx((50 - 99.2) / 335));
}

TEST_CASE("a camera that cannot be is refused with its cause") {
  Config config;
  config.camera = davis240();
  REQUIRE(check_camera(config).ok());
  const auto code = [&] { return check_camera(config).code(); };
  const double nan = std::numeric_limits<double>::quiet_NaN();

  SECTION("resolution") {
    for (std::int32_t bad : {-1, 0, 7, 1281, INT32_MAX}) {
      config.camera.intrinsics.width_px = bad;
      CHECK(code() == StatusCode::kBadResolution);
      config.camera.intrinsics.width_px = 240;
      config.camera.intrinsics.height_px = bad;
      CHECK(code() == StatusCode::kBadResolution);
      config.camera.intrinsics.height_px = 180;
    }
  }
  SECTION("focal length") {
    for (double bad : {0.0, -335.0, 5.0, 1e9, 1e300, nan}) {
      config.camera.intrinsics.fy_px = bad;
      CHECK(code() == StatusCode::kBadIntrinsics);
    }
  }
  SECTION("centre") {
    for (double bad : {-1.0, 241.0, 1e300, nan}) {
      config.camera.intrinsics.cx_px = bad;
      CHECK(code() == StatusCode::kBadIntrinsics);
    }
  }
  SECTION("grid") {
    config.grid = {240, 180, 335, 335, 120, 90};
    CHECK(code() == StatusCode::kOk);
    config.grid.height_px = 2000;
    CHECK(code() == StatusCode::kBadResolution);
    config.grid.height_px = 180;
    config.grid.fx_px = 1;
    CHECK(code() == StatusCode::kBadIntrinsics);
    CHECK(std::string(check_camera(config).subject()) == "grid focal length");
  }
  SECTION("plumb-bob that folds over inside the picture") {
    config.camera.coefficients[0] = -5;
    CHECK(code() == StatusCode::kBadDistortion);
    config.camera.coefficients[0] = nan;
    CHECK(code() == StatusCode::kBadDistortion);
  }
  SECTION("equidistant that never rises") {
    config.camera = mvsec_like();
    CHECK(code() == StatusCode::kOk);
    config.camera.coefficients[0] = -20;
    CHECK(code() == StatusCode::kBadDistortion);
  }
}
