// MVSEC's layout, written here as its own writer does it, converted and read back.
#include <catch2/catch.hpp>
#include <cmath>

#include "recording/mvsec_set.hpp"
#include "recording/replay.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using namespace egofocus::test;
using Catch::Matchers::Contains;

namespace {

std::string refuse(const MvsecSet& set, ExitCode code, const ConvertOptions& options = {}) {
  return complaint(code, InputFormat::kMvsec, set.data, set / "out", options);
}

}  // namespace

TEST_CASE("MVSEC: events, poses, IMU and depth of the left camera") {
  const MvsecSet set;
  CHECK(guess_format(set.data) == InputFormat::kMvsec);
  CHECK(guess_format(set.path()) == InputFormat::kMvsec);
  std::size_t progress = 0;
  ConvertOptions options;
  options.progress = [&](std::size_t done, std::size_t all) {
    if (all == 150000) progress = done;
  };
  const ConvertReport report = convert(InputFormat::kMvsec, set.path(), set / "out", options);
  CHECK(report.events == 150000);
  CHECK(progress == 150000);
  CHECK(report.t0_us == kEpochUs);
  CHECK(report.malformed + report.out_of_order + report.out_of_range + report.before_t0 == 0);
  CHECK(report.poses == 40);
  CHECK(report.widest_pose_gap_us == 50000);
  CHECK(report.imu_samples == 2);
  CHECK(report.imu_dropped == 2);
  CHECK(report.depth_pictures == 2);
  CHECK(report.depth_out_of_scale > 0);
  CHECK(report.left_out == std::vector<std::string>{"image_raw", "depth_image_rect"});
  CHECK(report.remarks.empty());

  const Folder folder = open_folder(set / "out");
  std::vector<Event> wanted = set.left;
  for (Event& event : wanted) event.t_us -= kEpochUs;
  check_same_events(events_of(folder), wanted);
  const Config& config = folder.camera.config;
  CHECK(config.camera.distortion == Distortion::kEquidistant);
  CHECK(config.camera.coefficients[3] == 0.036);
  CHECK(config.camera.intrinsics.fy_px == kFy);
  CHECK(config.grid.width_px == kWidth);
  CHECK(config.motion.source == MotionSource::kPoses);
  const Replay replay(open_folder(set / "out"));
  CHECK(replay.event_count() == 150000);
  CHECK(replay.default_first_tick_us() == 450000);

  REQUIRE(folder.poses.size() == 40);
  const PoseSample& pose = folder.poses[3];
  CHECK(pose.t_us == 150000);
  CHECK(pose.position_m[0] == Approx(0.3));
  CHECK(pose.position_m[2] == 2.0);
  CHECK(pose.orientation_xyzw[2] == Approx(std::sin(0.25)).margin(2e-9));
  CHECK(pose.orientation_xyzw[3] == Approx(std::cos(0.25)).margin(2e-9));
}

TEST_CASE("MVSEC: the IMU is the body, and its samples are on the bus") {
  const MvsecSet set;
  (void)convert(InputFormat::kMvsec, set.data, set / "out", {});
  const Folder folder = open_folder(set / "out");
  const std::vector<ImuSample> samples = imu_of(folder);
  REQUIRE(samples.size() == 4);  // gyro and accelerometer of two readings
  CHECK(samples[0].t_us == 300000);
  CHECK(samples[0].has_gyro);
  CHECK(samples[0].gyro_rad_s[2] == -0.5);
  CHECK(samples[1].accel_m_s2[0] == 0.5);
  CHECK(samples[1].accel_m_s2[2] == 9.75);
  CHECK(samples[3].t_us == 500000);
  const MotionConfig& motion = folder.camera.config.motion;
  CHECK(motion.camera_from_body[1] == -1.0);
  CHECK(motion.camera_from_body[3] == 1.0);
  // The camera's centre: -R^T t with R t as in the file.
  CHECK(motion.camera_in_body_m[0] == Approx(-0.02));
  CHECK(motion.camera_in_body_m[1] == Approx(0.01));
  CHECK(motion.camera_in_body_m[2] == Approx(-0.03));
}

TEST_CASE("MVSEC: depth moves from the distorted pixels to the undistorted grid") {
  const MvsecSet set;
  (void)convert(InputFormat::kMvsec, set.data, set / "out", {});
  const Folder folder = open_folder(set / "out");
  REQUIRE(folder.truth.size() == 2);
  CHECK(folder.truth[0].t_us == 450000);
  CHECK(folder.truth[1].t_us == 650000);
  const Picture<float> depth = read_depth(folder.truth[0], folder.camera);
  const std::vector<float> raw = distorted_plane();
  int known = 0;
  int raw_is_wrong = 0;
  double worst = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const double got = static_cast<double>(depth.at(column, row));
      const double true_m = plane_depth((column - kCx) / kFx, (row - kCy) / kFy);
      raw_is_wrong +=
          std::abs(static_cast<double>(raw[static_cast<std::size_t>(row * kWidth + column)]) / true_m - 1) >
          0.02;
      if (got == 0) continue;
      ++known;
      worst = std::max(worst, std::abs(got / true_m - 1));
    }
  }
  CHECK(known > 60000);
  CHECK(worst < 0.011);               // half a sensor pixel, where slant and fisheye are steepest, and 1 mm
  CHECK(raw_is_wrong > 10000);        // the same picture without the move would be seen
  CHECK(depth.at(174, 134) == 0.0f);  // NaN: near the centre a pixel stays where it is
  CHECK(depth.at(200, 134) == 0.0f);  // 500 m
  CHECK(read_depth(folder.truth[1], folder.camera).at(200, 134) ==
        Approx(plane_depth(26.4 / kFx, 0.3 / kFy)).epsilon(0.005));
}

TEST_CASE("MVSEC: the right camera has poses and calibration of its own") {
  const MvsecSet set;
  ConvertOptions options;
  options.camera = CameraSide::kRight;
  const ConvertReport report = convert(InputFormat::kMvsec, set.data, set / "out", options);
  CHECK(report.events == 900);
  CHECK(report.imu_samples == 0);
  const Folder folder = open_folder(set / "out");
  CHECK(folder.camera.config.camera.intrinsics.fx_px == 225.0);
  // 0.1 m along the left camera's x axis, which is turned by 0.5 rad.
  CHECK(folder.poses[0].position_m[0] == Approx(0.1 * std::cos(0.5)).margin(2e-9));
  CHECK(folder.poses[0].position_m[1] == Approx(-1 + 0.1 * std::sin(0.5)).margin(2e-9));
}

TEST_CASE("MVSEC: pictures compressed with LZF, as the set has them") {
  const MvsecSet set;
  (void)convert(InputFormat::kMvsec, set.data, set / "plain", {});
  {
    const LzfEncoder encoder;
    set.write_truth(kLzf);
  }
  CHECK(convert(InputFormat::kMvsec, set.data, set / "out", {}).depth_pictures == 2);
  const Folder plain = open_folder(set / "plain");
  const Folder folder = open_folder(set / "out");
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(read_depth(folder.truth[i], folder.camera).pixels ==
          read_depth(plain.truth[i], plain.camera).pixels);
  }
}

TEST_CASE("MVSEC: data alone is a recording whose report says what it lacks") {
  const MvsecSet set;
  std::filesystem::remove(set.truth);
  const ConvertReport report = convert(InputFormat::kMvsec, set.data, set / "out", {});
  CHECK(report.poses == 0);
  REQUIRE(report.remarks.size() == 2);
  CHECK_THAT(report.remarks[0], Contains("No ground truth"));
  CHECK_THAT(report.remarks[1], Contains("without velocity"));
  CHECK(open_folder(set / "out").camera.config.motion.source == MotionSource::kOdometry);
}

TEST_CASE("MVSEC: what is wrong with a file is said") {
  MvsecSet set;
  const auto rewrite = [&](auto&& work) {
    Hdf5Writer file(set.data);
    work(file);
  };
  rewrite([](Hdf5Writer& file) {
    file.write("/davis/left/image_raw", H5T_IEEE_F32LE, {1}, std::vector<float>{0});
  });
  CHECK_THAT(refuse(set, ExitCode::kBadFile),
             Contains("flying_data.hdf5:/davis/left/events: is not in the file"));
  rewrite([](Hdf5Writer& file) {
    file.write("/davis/left/events", H5T_STD_I64LE, {1, 4}, std::vector<std::int64_t>(4));
  });
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("wrong type: floats are needed"));
  rewrite([](Hdf5Writer& file) {
    file.write("/davis/left/events", H5T_IEEE_F64LE, {4}, std::vector<double>(4));
  });
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("has 1 dimensions; 2 are needed"));
  rewrite([](Hdf5Writer& file) {
    file.write("/davis/left/events", H5T_IEEE_F64LE, {1, 5}, std::vector<double>(5));
  });
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("four columns x y t p"));
  rewrite([](Hdf5Writer& file) {
    file.write("/davis/left/events", H5T_IEEE_F64LE, {0, 4}, std::vector<double>());
  });
  CHECK_THAT(refuse(set, ExitCode::kNoEvents), Contains("has no event"));
  rewrite([](Hdf5Writer& file) {
    file.write("/davis/left/events", H5T_IEEE_F64LE, {100, 4}, std::vector<double>());
  });
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("100 rows, but no data was ever written"));
  rewrite([](Hdf5Writer& file) {
    file.write("/davis/left/events", H5T_IEEE_F64LE, {3, 4},
               std::vector<double>{NAN, 1, 5, 1, 1, 1, 1e300, 1, 400, 1, 5, 1});
  });
  CHECK_THAT(refuse(set, ExitCode::kNoEvents), Contains("2 malformed, 1 outside"));

  set.write_data();
  std::filesystem::resize_file(set.data, std::filesystem::file_size(set.data) / 2);
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("truncated"));
  write_text_file(set.data, "hello world");
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("is no HDF5 file"));
  std::filesystem::remove(set.data);
  CHECK_THAT(refuse(set, ExitCode::kFile), Contains("cannot be opened"));
}

TEST_CASE("MVSEC: truth and calibration that do not fit are refused") {
  MvsecSet set;
  {
    Hdf5Writer file(set.truth);
    file.write("/davis/left/odometry", H5T_IEEE_F64LE, {1, 4, 4}, std::vector<double>(16));
    file.write("/davis/left/odometry_ts", H5T_IEEE_F64LE, {2}, std::vector<double>(2));
  }
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("1 rows, but there are 2 times"));
  set.write_truth();
  const auto swap = [&](const std::string& from, const std::string& to) {
    std::string text = kCamchain;
    text.replace(text.find(from), from.size(), to);
    write_text_file(set / "camchain-imucam-flying.yaml", text);
  };
  swap("resolution: [346, 260]", "resolution: [240, 180]");
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("another size than the calibration"));
  swap("camera_model: pinhole", "camera_model: omni");
  CHECK_THAT(refuse(set, ExitCode::kConfiguration), Contains("omni"));
  swap("equidistant", "fov");
  CHECK_THAT(refuse(set, ExitCode::kConfiguration), Contains("radtan, equidistant and none are known"));
  swap("intrinsics: [226.4, 226.1, 173.6, 133.7]", "intrinsics: [226.4, 226.1, 173.6]");
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("`cam0.intrinsics` has 3 values; 4 are needed"));
  swap("226.1", "wide");
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("`wide`, which is no number"));
  swap("[0.0, -1.0, 0.0, 0.01]", "[0.0, -2.0, 0.0, 0.01]");
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("`cam0.T_cam_imu` is no rigid transform"));
  swap("[346, 260]", "[346, 260");
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("is no good YAML"));
  std::filesystem::remove(set / "camchain-imucam-flying.yaml");
  CHECK_THAT(refuse(set, ExitCode::kConfiguration), Contains("--kalibr"));
}
