#include "recording/camera_toml.hpp"

#include <catch2/catch.hpp>
#include <cstring>

#include "recording/error.hpp"
#include "recording/text_file.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using Catch::Matchers::Contains;

namespace {

const std::string kCamera =
    "[camera]\nwidth_px = 240\nheight_px = 180\nfx_px = 200\nfy_px = 199.5\ncx_px = 120\ncy_px = 90\n";

/// The message of the error that the text causes.
std::string complaint(const std::string& text) {
  try {
    (void)parse_camera_toml(text, "camera.toml");
  } catch (const Error& error) {
    CHECK(error.exit_code() == static_cast<int>(ExitCode::kConfiguration));
    return error.what();
  }
  return "no complaint";
}

}  // namespace

TEST_CASE("a camera section alone is enough, and leaves the defaults") {
  const CameraFile file = parse_camera_toml(kCamera, "camera.toml");
  CHECK(file.config.camera.intrinsics.width_px == 240);
  CHECK(file.config.camera.intrinsics.fx_px == 200.0);
  CHECK(file.config.camera.intrinsics.fy_px == 199.5);
  CHECK(file.config.camera.distortion == Distortion::kNone);
  CHECK(file.config.grid.width_px == 0);
  CHECK(file.config.ladder.hypotheses == LadderConfig{}.hypotheses);
  CHECK(file.depth_scale_m == 0.001);
  CHECK(file.can.motion.signal_count == 0);
}

TEST_CASE("each section reaches its field") {
  const CameraFile file = parse_camera_toml(
      kCamera +
          "distortion = \"plumb_bob\"\ncoefficients = [-0.1, 0.2]\n"
          "[grid]\nwidth_px = 346\nheight_px = 260\nfx_px = 1\nfy_px = 2\ncx_px = 3\ncy_px = 4\n"
          "[ladder]\nkind = \"metric\"\nhypotheses = 32\n[window]\nmax_age_us = 123\n"
          "[filter]\nrefractory_us = 7\n[motion]\nsource = \"poses\"\nmodel = \"wheeled\"\ncamera_in_body_m "
          "= [1, 2, 3]\n"
          "[focus]\ncost = \"sti\"\nsupport_cells = 7\nsmoothing = false\n[carry]\nmax_age_us = "
          "5\nmax_travel = 0.25\nmin_in_view = 0.5\nfuse_us = 300000\n[rate]\nrate_hz = "
          "40\n[rings]\nevents = 131072\n"
          "[depth]\nscale_m = 0.002\n[can]\ndbc = \"a.dbc\"\ngyro_axes = [\"y\", \"-x\", \"z\"]\n"
          "[[can.signals]]\nmessage = \"M\"\nsignal = \"S\"\nrole = \"wheel_speed\"\nunit = \"km/h\"\nscale "
          "= -1\n"
          "raw_max = 64255\n",
      "camera.toml");
  CHECK(file.config.camera.distortion == Distortion::kPlumbBob);
  CHECK(file.config.camera.coefficients[1] == 0.2);
  CHECK(file.config.camera.coefficients[2] == 0.0);
  CHECK(file.config.grid.height_px == 260);
  CHECK(file.config.grid.cy_px == 4.0);
  CHECK(file.config.ladder.kind == LadderKind::kMetric);
  CHECK(file.config.ladder.hypotheses == 32);
  CHECK(file.config.window.max_age_us == 123);
  CHECK(file.config.filter.refractory_us == 7);
  CHECK(file.config.motion.source == MotionSource::kPoses);
  CHECK(file.config.motion.model == MotionModel::kWheeled);
  CHECK(file.config.motion.camera_in_body_m[2] == 3.0);
  CHECK(file.config.focus.cost == FocusCost::kSti);
  CHECK(file.config.carry.max_age_us == 5);
  CHECK(file.config.carry.max_travel == 0.25);
  CHECK(file.config.carry.min_in_view == 0.5);
  CHECK(file.config.carry.fuse_us == 300'000);
  CHECK(file.config.rate.rate_hz == 40.0);
  CHECK(file.config.rings.events == 131072);
  CHECK(file.depth_scale_m == 0.002);
  CHECK(file.can.dbc == "a.dbc");
  CHECK(file.can.motion.gyro_axes.from[0] == 2);
  CHECK(file.can.motion.gyro_axes.from[1] == -1);
  REQUIRE(file.can.motion.signal_count == 1);
  const CanSignalRole& signal = file.can.motion.signals[0];
  CHECK(std::string(signal.message) == "M");
  CHECK(signal.role == CanRole::kWheelSpeed);
  CHECK(signal.unit == CanUnit::kKmPerHour);
  CHECK(signal.scale == -1.0);
  CHECK(signal.raw_max == 64255);
}

TEST_CASE("what is written reads back bit for bit") {
  CameraFile file = parse_camera_toml(kCamera, "camera.toml");
  file.config.camera.intrinsics.fx_px = 1.0 / 3.0;
  file.config.camera.coefficients[4] = -1e-17;
  file.config.grid = {100, 50, 70.125, 71, 49.5, 24.5};
  file.config.motion.stale_after_us = 1234567890123;
  file.can.dbc = "odd \"name\".dbc";
  std::strcpy(file.can.motion.signals[0].message, "M");
  std::strcpy(file.can.motion.signals[0].signal, "S");
  file.can.motion.signals[0].role = CanRole::kVarianceYz;
  file.can.motion.signals[0].unit = CanUnit::kStandardGravity;
  file.can.motion.signal_count = 1;
  const std::string text = camera_toml_text(file);
  const CameraFile again = parse_camera_toml(text, "again");
  CHECK(again.config.camera.intrinsics.fx_px == file.config.camera.intrinsics.fx_px);
  CHECK(again.config.camera.coefficients[4] == file.config.camera.coefficients[4]);
  CHECK(again.config.grid.fx_px == 70.125);
  CHECK(again.config.motion.stale_after_us == 1234567890123);
  CHECK(again.can.dbc == file.can.dbc);
  CHECK(again.can.motion.signals[0].role == CanRole::kVarianceYz);
  CHECK(again.can.motion.signals[0].raw_max == UINT64_MAX);
  CHECK(camera_toml_text(again) == text);
}

TEST_CASE("each mistake in camera.toml is named with its line and its remedy") {
  CHECK_THAT(complaint("width_px = 3\n" + kCamera),
             Contains("camera.toml:1: unknown section or key `width_px`") && Contains("[ladder]"));
  CHECK_THAT(complaint(""), Contains("lacks the section [camera]"));
  CHECK_THAT(complaint("[camera]\nwidth_px = 240\n"),
             Contains("camera.toml:1: [camera] lacks the key `height_px`"));
  CHECK_THAT(complaint(kCamera + "fov = 3\n"), Contains("camera.toml:8: [camera] has no key `fov`") &&
                                                   Contains("Known keys: width_px, height_px"));
  CHECK_THAT(
      complaint(kCamera + "distortion = \"fisheye\"\n"),
      Contains(
          "camera.toml:8: [camera] `distortion` must be one of \"none\", \"plumb_bob\", \"equidistant\""));
  CHECK_THAT(complaint(kCamera + "coefficients = [1, 2, 3, 4, 5, 6]\n"), Contains("list of up to 5 values"));
  CHECK_THAT(complaint(kCamera + "coefficients = [\"a\"]\n"), Contains("`coefficients` must be a number"));
  CHECK_THAT(complaint(kCamera + "[motion]\ncamera_in_body_m = [1, 2]\n"),
             Contains("camera.toml:9") && Contains("list of 3 values"));
  CHECK_THAT(complaint(kCamera + "[ladder]\nhypotheses = 1.5\n"), Contains("must be an integer"));
  CHECK_THAT(complaint(kCamera + "[ladder]\nhypotheses = 3000000000\n"),
             Contains("must lie in -2147483648 .. 2147483647"));
  CHECK_THAT(complaint(kCamera + "[rings]\nevents = -1\n"), Contains("must lie in 0 .. 4294967295"));
  CHECK_THAT(complaint(kCamera + "[grid]\nwidth_px = 3\n"), Contains("[grid] lacks the key `height_px`"));
  CHECK_THAT(complaint(kCamera + "[ladder\n"), Contains("camera.toml:8: is no valid TOML"));
  CHECK_THAT(complaint("camera = 5\n"), Contains("camera.toml:1: `camera` must be a section [camera]"));
  CHECK_THAT(complaint(kCamera + "[can]\n"), Contains("camera.toml:8: [can] lacks the key `dbc`"));
}

TEST_CASE("each mistake in [can] is named, too") {
  const std::string can = kCamera + "[can]\ndbc = \"a.dbc\"\n";
  const std::string signal = "[[can.signals]]\nmessage = \"M\"\nsignal = \"S\"\n";
  CHECK_THAT(complaint(can + "[[can.signals]]\nmessage = \"M\"\nrole = \"gyro_x\"\n"),
             Contains("camera.toml:10: [[can.signals]] lacks the key `signal`"));
  CHECK_THAT(complaint(can + signal), Contains("[[can.signals]] lacks the key `role`"));
  CHECK_THAT(complaint(can + signal + "role = \"yaw\"\n"),
             Contains("camera.toml:13: [[can.signals]] `role` must be one of gyro_x, gyro_y"));
  CHECK_THAT(complaint(can + signal + "role = \"gyro_x\"\nunit = \"rpm\"\n"),
             Contains("`unit` must be one of si, deg/s, g, km/h"));
  CHECK_THAT(complaint(can + "gyro_axes = [\"x\", \"y\", \"w\"]\n"),
             Contains("`gyro_axes` must be one of \"x\""));
  CHECK_THAT(complaint(can + "signals = 3\n"), Contains("must be a list of tables"));
  CHECK_THAT(complaint(can + "[[can.signals]]\nmessage = \"" + std::string(64, 'm') + "\"\n"),
             Contains("at most 63 characters"));
  CHECK_THAT(complaint(can + signal + "role = \"gyro_x\"\nraw_max = -5\n"), Contains("must not be negative"));
  std::string many = can;
  for (int i = 0; i < 33; ++i) many += signal + "role = \"wheel_speed\"\n";
  CHECK_THAT(complaint(many), Contains("at most 32 entries"));
}

TEST_CASE("[usb] sets a live camera, and each of its mistakes is named") {
  const std::string usb =
      kCamera +
      "[usb]\nserial = \"00000346\"\nimu = true\nimu_axes = [\"z\", \"-x\", \"y\"]\nreopen = false\n";
  const std::string bias = "[[usb.biases]]\nname = \"OnBn\"\n";
  const CameraFile file = parse_camera_toml(
      usb + "transfers = 8\nsensitivity = \"high\"\n" + bias + "coarse = 5\nfine = 200\n", "camera.toml");
  CHECK(file.usb.is_given);
  const UsbCameraSettings& camera = file.usb.camera;
  CHECK(std::string(camera.serial) == "00000346");
  CHECK(camera.imu);
  CHECK(camera.imu_axes.from[1] == -1);
  CHECK_FALSE(camera.reopen);
  CHECK(camera.transfers == 8);
  CHECK(camera.sensitivity == UsbSensitivity::kHigh);
  REQUIRE(camera.bias_count == 1);
  CHECK(std::string(camera.biases[0].name) == "OnBn");
  CHECK(camera.biases[0].coarse == 5);
  CHECK(camera.biases[0].fine == 200);
  CHECK(camera.biases[0].offset == 0);
  const CameraFile again = parse_camera_toml(camera_toml_text(file), "again.toml");
  CHECK(camera_toml_text(again) == camera_toml_text(file));
  CHECK(again.usb.camera.biases[0].fine == 200);
  CHECK_FALSE(parse_camera_toml(kCamera, "camera.toml").usb.is_given);

  CHECK_THAT(complaint(usb + "gain = 1\n"), Contains("[usb] has no key `gain`"));
  CHECK_THAT(complaint(usb + bias + "corse = 1\n"), Contains("[[usb.biases]] has no key `corse`"));
  CHECK_THAT(complaint(usb + "[[usb.biases]]\ncoarse = 1\n"),
             Contains("[[usb.biases]] lacks the key `name`"));
  CHECK_THAT(complaint(usb + "sensitivity = \"highest\"\n"),
             Contains("`sensitivity` must be one of \"very_low\""));
  CHECK_THAT(complaint(kCamera + "[usb]\nserial = \"" + std::string(24, '1') + "\"\n"),
             Contains("`serial`") && Contains("at most 23 characters"));
  CHECK_THAT(complaint(usb + "biases = 3\n"), Contains("must be a list of tables [[usb.biases]]"));
}

TEST_CASE("[v4l2] sets a live sensor, and each of its mistakes is named") {
  const std::string v4l2 = kCamera + "[v4l2]\ndevice = \"genx320\"\nframe_end = \"marker\"\nbuffers = 8\n";
  const std::string control = "[[v4l2.controls]]\nname = \"bias_fo\"\n";
  const CameraFile file =
      parse_camera_toml(v4l2 + "format = \"evt21me\"\n" + control + "value = 34\n", "camera.toml");
  CHECK(file.v4l2.is_given);
  const V4l2CameraSettings& camera = file.v4l2.camera;
  CHECK(std::string(camera.device) == "genx320");
  CHECK(camera.has_format);
  CHECK(camera.format == EvtFormat::kEvt21Legacy);
  CHECK(camera.frame_end == V4l2FrameEnd::kMarker);
  CHECK(camera.buffers == 8);
  REQUIRE(camera.control_count == 1);
  CHECK(std::string(camera.controls[0].name) == "bias_fo");
  CHECK(camera.controls[0].value == 34);
  const CameraFile again = parse_camera_toml(camera_toml_text(file), "again.toml");
  CHECK(camera_toml_text(again) == camera_toml_text(file));
  CHECK(again.v4l2.camera.format == EvtFormat::kEvt21Legacy);
  CHECK_FALSE(parse_camera_toml(v4l2, "camera.toml").v4l2.camera.has_format);
  CHECK_FALSE(parse_camera_toml(kCamera, "camera.toml").v4l2.is_given);

  CHECK_THAT(complaint(v4l2 + "gain = 1\n"), Contains("[v4l2] has no key `gain`"));
  CHECK_THAT(complaint(v4l2 + "format = \"evt4\"\n"), Contains("`format` must be one of \"sensor\""));
  CHECK_THAT(complaint(v4l2 + "[[v4l2.controls]]\nvalue = 1\n"), Contains("lacks the key `name`"));
  CHECK_THAT(complaint(kCamera + "[v4l2]\ndevice = \"" + std::string(64, '1') + "\"\n"),
             Contains("`device`") && Contains("at most 63 characters"));
}

TEST_CASE("the example of docs/formats.md is a good file") {
  const std::string page = read_text_file(egofocus::test::source_dir() + "/docs/formats.md");
  const std::size_t begin = page.find("```toml\n") + 8;
  const CameraFile file =
      parse_camera_toml(page.substr(begin, page.find("```", begin) - begin), "formats.md");
  CHECK(file.config.motion.model == MotionModel::kWheeled);
  CHECK(file.can.motion.signal_count == 2);
  CHECK(file.can.motion.gyro_axes.from[2] == -3);
}

TEST_CASE("docs/formats.md names each key that can be set") {
  const std::string page = read_text_file(egofocus::test::source_dir() + "/docs/formats.md");
  CameraFile file = parse_camera_toml(kCamera, "camera.toml");
  file.config.grid = file.config.camera.intrinsics;
  file.can.motion.signal_count = 1;
  file.can.motion.signals[0].raw_max = 1;
  file.usb.is_given = true;
  file.usb.camera.bias_count = 1;
  file.v4l2.is_given = true;
  file.v4l2.camera.control_count = 1;
  const std::string text = camera_toml_text(file);
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
    const std::string line = text.substr(at, text.find('\n', at) - at);
    const std::string word = line.substr(0, line.find(" ="));
    INFO(word);
    CHECK(page.find(word) != std::string::npos);
  }
}
