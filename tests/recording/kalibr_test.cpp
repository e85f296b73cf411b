#include "recording/kalibr.hpp"

#include <catch2/catch.hpp>

#include "egofocus/engine.hpp"
#include "recording/error.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using Catch::Matchers::Contains;

namespace {

std::vector<KalibrCamera> read(const std::string& text) {
  const TemporaryFolder at;
  write_text_file(at / "camchain.yaml", text);
  return read_kalibr(at / "camchain.yaml");
}

}  // namespace

TEST_CASE("a camera chain: models, sizes and transforms") {
  const std::vector<KalibrCamera> cameras = read(R"(# as Kalibr writes it
cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.36, 0.15, 2.5e-4, -1.e-3]
  distortion_model: radtan
  intrinsics: [199.5, 199., 132.25, 110.5]
  resolution: [240, 180]
  rostopic: /dvs/image_raw
cam1:
  T_cn_cnm1:
  - [0.0, -1.0, 0.0, 0.1]
  - [1.0, 0.0, 0.0, 0.2]
  - [0.0, 0.0, 1.0, 0.3]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_model: none
  intrinsics: [600, 601, 320, 240]
  resolution: [640, 480]
cam3: {camera_model: omni}
)");
  REQUIRE(cameras.size() == 2);  // the chain ends where a camera is missing
  const CameraModel& first = cameras[0].model;
  CHECK(first.distortion == Distortion::kPlumbBob);
  CHECK(first.coefficients[2] == 2.5e-4);
  CHECK(first.coefficients[3] == -1e-3);
  CHECK(first.coefficients[4] == 0);
  CHECK(first.intrinsics.fy_px == 199.0);
  CHECK(first.intrinsics.cx_px == 132.25);
  CHECK(first.intrinsics.height_px == 180);
  CHECK_FALSE(cameras[0].camera_from_imu.has_value());
  CHECK(cameras[1].model.distortion == Distortion::kNone);
  REQUIRE(cameras[1].camera_from_previous.has_value());
  CHECK(cameras[1].camera_from_previous->rotation[1] == -1.0);
  CHECK(cameras[1].camera_from_previous->rotation[3] == 1.0);
  CHECK(cameras[1].camera_from_previous->translation_m[2] == 0.3);
}

TEST_CASE("a rounded T_cam_imu is good enough for the library") {
  const std::vector<KalibrCamera> cameras = read(
      "cam0:\n  camera_model: pinhole\n  intrinsics: [200, 200, 120, 90]\n  resolution: [240, 180]\n"
      "  distortion_model: none\n"
      "  T_cam_imu: [[0.866, -0.5, 0, 0.01], [0.5, 0.866, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n");
  Config config;
  config.camera = cameras.at(0).model;
  set_body(config.motion, cameras[0].camera_from_imu.value());
  CHECK(config.motion.camera_from_body[0] == Approx(0.866).epsilon(1e-4));
  CHECK(config.motion.camera_from_body[1] == Approx(-0.5).epsilon(1e-4));
  std::size_t bytes = 0;
  CHECK(Engine::required_arena(config, bytes).ok());
}

TEST_CASE("a file that is no camera chain says why") {
  CHECK_THROWS_WITH(read(""), Contains("has no `cam0.camera_model`"));
  CHECK_THROWS_WITH(read("- 1\n- 2\n"), Contains("has no `cam0.camera_model`"));
  CHECK_THROWS_WITH(read("cam0: [\n"), Contains("camchain.yaml:") && Contains("is no good YAML"));
  CHECK_THROWS_WITH(read("cam0:\n  camera_model: pinhole\n"), Contains("has no `cam0.intrinsics`"));
  CHECK_THROWS_WITH(read("cam0:\n  camera_model: [pinhole, omni]\n"), Contains("must be one value"));
  const std::string start = "cam0:\n  camera_model: pinhole\n  intrinsics: [1, 1, 1, 1]\n";
  CHECK_THROWS_WITH(read(start + "  resolution: [0, 180]\n"), Contains("is no size in pixels"));
  CHECK_THROWS_WITH(read(start + "  resolution: [nan, 180]\n"), Contains("`nan`, which is no number"));
  // A kilobyte that stands for ten billion numbers.
  std::string bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before;
    for (int k = 1; k < 10; ++k) bomb += ", " + before;
    bomb += "]\n";
  }
  CHECK_THROWS_WITH(read(bomb), Contains("too deep or too large"));
  CHECK_THROWS_WITH(read(std::string(2'000'000, '#')), Contains("too large for a calibration"));
  CHECK_THROWS_WITH(read(std::string(5000, '[')), Contains("is no good YAML"));
}
