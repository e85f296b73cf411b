// DSEC's layout, written here after the data set's description, converted and read back.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "recording/converted.hpp"
#include "recording/hdf5_writer.hpp"
#include "recording/png_io.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using namespace egofocus::test;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kOffsetUs = 51'648'500'123;
constexpr double kTilt = 0.05;  // the rectified view is turned by so much about y
constexpr double kFocal = 569.76;
constexpr double kCx = 335.1;
constexpr double kCy = 221.2;
constexpr double kBaseline = 0.6;

const std::string kCalibration = R"(intrinsics:
  cam0:
    camera_matrix: [555.66, 555.83, 342.57, 215.27]
    camera_model: pinhole
    distortion_coeffs: [-0.0909, 0.1834, -0.0007, 0.0004]
    distortion_model: radtan
    resolution: [640, 480]
  camRect0:
    camera_matrix: [569.76, 569.76, 335.1, 221.2]
    resolution: [640, 480]
extrinsics:
  R_rect0:
  - [0.99875026039496628, 0.0, 0.04997916927067833]
  - [0.0, 1.0, 0.0]
  - [-0.04997916927067833, 0.0, 0.99875026039496628]
disparity_to_depth:
  cams_03:
  - [1.0, 0.0, 0.0, -335.1]
  - [0.0, 1.0, 0.0, -221.2]
  - [0.0, 0.0, 0.0, 569.76]
  - [0.0, 0.0, 1.6666666666666667, 0.0]
)";

/// The plane 0.8 x + 0.4 y + z = 12 in the raw camera's frame: its depth along the ray (x, y, 1).
double plane_depth(double x, double y) {
  return 12.0 / (1.0 + 0.8 * x + 0.4 * y);
}

/// The same plane as disparity on the rectified view, times 256.
Grey16Picture plane_disparity() {
  Grey16Picture picture(640, 480);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const double x = (u - kCx) / kFocal;
      const double y = (v - kCy) / kFocal;
      // The ray in the camera's frame: the inverse turn about y. Depth in the rectified view is where it
      // meets.
      const double camera_x = std::cos(kTilt) * x - std::sin(kTilt);
      const double camera_z = std::sin(kTilt) * x + std::cos(kTilt);
      const double rectified_m = 12.0 / (0.8 * camera_x + 0.4 * y + camera_z);
      picture.at(u, v) = static_cast<std::uint16_t>(std::lround(kFocal * kBaseline / rectified_m * 256));
    }
  }
  return picture;
}

struct DsecSet : TemporaryFolder {
  std::vector<Event> events = some_events(100001, 640, 480, 77);
  fs::path input = *this / "zurich";
  fs::path events_file = input / "events/left/events.h5";

  explicit DsecSet(H5Z_filter_t filter = 0) {
    for (const char* folder : {"events/left", "calibration", "disparity/event", "images"})
      fs::create_directories(input / folder);
    write_text_file(input / "calibration/cam_to_cam.yaml", kCalibration);
    write_events(filter);
    const Grey16Picture disparity = plane_disparity();
    Grey16Picture empty = disparity;
    empty.at(320, 240) = 0;
    write_png(input / "disparity/event/000000.png", disparity);
    write_png(input / "disparity/event/000002.png", empty);
    write_text_file(input / "disparity/timestamps.txt",
                    std::to_string(kOffsetUs + 200000) + "\n" + std::to_string(kOffsetUs + 300000) + "\n");
  }

  void write_events(H5Z_filter_t filter) const {
    std::vector<std::int64_t> columns[4];
    for (const Event& event : events) {
      columns[0].push_back(event.t_us);
      columns[1].push_back(event.x);
      columns[2].push_back(event.y);
      columns[3].push_back(event.polarity);
    }
    Hdf5Writer file(events_file);
    const hid_t stored[4] = {H5T_STD_U32LE, H5T_STD_U16LE, H5T_STD_U16LE, H5T_STD_U8LE};
    const char* const names[4] = {"/events/t", "/events/x", "/events/y", "/events/p"};
    for (std::size_t i = 0; i < 4; ++i)
      file.write(names[i], stored[i], {events.size()}, columns[i], filter, 16384);
    file.write("/ms_to_idx", H5T_STD_U64LE, {1}, std::vector<std::int64_t>{0});
    file.write("/t_offset", H5T_STD_I64LE, {}, std::vector<std::int64_t>{kOffsetUs});
  }
};

std::string refuse(const DsecSet& set, ExitCode code, const ConvertOptions& options = {}) {
  return complaint(code, InputFormat::kDsec, set.input, set / "out", options);
}

void check_converted(const DsecSet& set) {
  const ConvertReport report = convert(guess_format(set.input), set.input, set / "out", {});
  CHECK(report.events == 100001);
  CHECK(report.t0_us == 51'648'000'000);
  CHECK(report.depth_pictures == 2);
  CHECK(report.left_out == std::vector<std::string>{"images"});
  REQUIRE(report.remarks.size() == 1);
  CHECK_THAT(report.remarks[0], Contains("No motion: a replay needs poses"));
  MappedFile file(set / "out/events.raw");
  Folder folder;
  folder.events = std::move(file);
  std::vector<Event> wanted = set.events;
  for (Event& event : wanted) event.t_us += kOffsetUs - report.t0_us;
  check_same_events(events_of(folder), wanted);
}

}  // namespace

TEST_CASE("DSEC: events without compression, and a replay is told that poses are missing") {
  const DsecSet set;
  CHECK(guess_format(set.input) == InputFormat::kDsec);
  check_converted(set);
  CHECK_THROWS_WITH(open_folder(set / "out"), Contains("no motion"));
}

TEST_CASE("DSEC: events compressed with Blosc, as the set has them") {
  if (!filter_available(kBlosc)) {
    WARN("no Blosc plugin for HDF5 (Debian: hdf5-filter-plugin-blosc-serial): not exercised");
    return;
  }
  const DsecSet set(kBlosc);
  REQUIRE(fs::file_size(set.events_file) < 100001 * 9 / 2);  // it is compressed
  check_converted(set);
}

TEST_CASE("DSEC: poses from a file, on the data's clock") {
  const DsecSet set;
  write_text_file(set / "poses.txt",
                  "51648.5 0 0 0 0 0 0 1\n51648.55 1 0 0 0 0 0 1\n51649.5 2 0 0 0 0 0 1\n");
  ConvertOptions options;
  options.poses = set / "poses.txt";
  const ConvertReport report = convert(InputFormat::kDsec, set.input, set / "out", options);
  CHECK(report.poses == 3);
  CHECK(report.widest_pose_gap_us == 950000);
  CHECK(report.events_before_poses == 0);
  CHECK(report.events_after_poses == 100001 - 3 * 19997);
  REQUIRE(report.remarks.size() == 1);
  CHECK_THAT(report.remarks[0], Contains("max_pose_gap_us"));
}

TEST_CASE("DSEC: disparity on the rectified view becomes depth on the raw camera's grid") {
  const DsecSet set;
  write_text_file(set / "poses.txt", "51648.5 0 0 0 0 0 0 1\n51648.55 1 0 0 0 0 0 1\n");
  ConvertOptions options;
  options.poses = set / "poses.txt";
  (void)convert(InputFormat::kDsec, set.input, set / "out", options);
  const Folder folder = open_folder(set / "out");
  REQUIRE(folder.truth.size() == 2);
  CHECK(folder.truth[0].t_us == kOffsetUs + 200000 - 51'648'000'000);
  const Picture<float> depth = read_depth(folder.truth[0], folder.camera);
  const Grey16Picture rectified = plane_disparity();
  int known = 0;
  int rectified_is_wrong = 0;
  double worst = 0;
  for (int row = 0; row < 480; ++row) {
    for (int column = 0; column < 640; ++column) {
      const double true_m = plane_depth((column - 342.57) / 555.66, (row - 215.27) / 555.83);
      const double taken_as_is_m = kFocal * kBaseline * 256 / rectified.at(column, row);
      rectified_is_wrong += std::abs(taken_as_is_m / true_m - 1) > 0.02;
      const double got = static_cast<double>(depth.at(column, row));
      if (got == 0) continue;
      ++known;
      worst = std::max(worst, std::abs(got / true_m - 1));
    }
  }
  CHECK(known > 250000);
  CHECK(worst < 0.0035);  // half a pixel of this slant, 1/512 px of disparity, 1 mm
  CHECK(rectified_is_wrong > 100000);
  // The two pictures differ in one rectified pixel; a turn of the view moves it by whole pixels, never blurs
  // it.
  const Picture<float> holed = read_depth(folder.truth[1], folder.camera);
  int holes = 0;
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
    const bool hole = depth.pixels[i] > 0 && holed.pixels[i] == 0;
    holes += hole;
    CHECK((hole || depth.pixels[i] == holed.pixels[i]));
  }
  CHECK(holes >= 1);
  CHECK(holes <= 2);
}

TEST_CASE("DSEC: what is wrong with a sequence is said") {
  DsecSet set;
  ConvertOptions right;
  right.camera = CameraSide::kRight;
  CHECK_THAT(refuse(set, ExitCode::kUsage, right), Contains("left is read"));

  write_text_file(set.input / "disparity/timestamps.txt", "51648700123\n");
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("1 times for 2 pictures"));
  write_text_file(set.input / "disparity/timestamps.txt", "51648700123\n5.5\n");
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("entry 2 is no whole number"));
  fs::remove(set.input / "disparity/timestamps.txt");
  CHECK_THAT(refuse(set, ExitCode::kFile), Contains("has no timestamps.txt"));
  fs::remove_all(set.input / "disparity");
  CHECK(convert(InputFormat::kDsec, set.input, set / "dark", {}).depth_pictures == 0);

  const auto rewrite = [&](std::size_t x_rows, hid_t t_type, bool offset) {
    Hdf5Writer file(set.events_file);
    file.write("/events/t", t_type, {2}, std::vector<std::int64_t>{1, 2});
    file.write("/events/x", H5T_STD_U16LE, {x_rows}, std::vector<std::int64_t>(x_rows));
    file.write("/events/y", H5T_STD_U16LE, {2}, std::vector<std::int64_t>{1, 2});
    file.write("/events/p", H5T_STD_U8LE, {2}, std::vector<std::int64_t>{0, 1});
    if (offset) file.write("/t_offset", H5T_STD_I64LE, {}, std::vector<std::int64_t>{5});
  };
  rewrite(2, H5T_STD_U32LE, true);
  CHECK(convert(InputFormat::kDsec, set.input, set / "short", {}).events == 2);
  rewrite(3, H5T_STD_U32LE, true);
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("/events/x: has another length"));
  rewrite(2, H5T_IEEE_F64LE, true);
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("integers are needed"));
  rewrite(2, H5T_STD_U32LE, false);
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("/t_offset: is not in the file"));
  set.write_events(0);
  fs::resize_file(set.events_file, fs::file_size(set.events_file) - 5000);
  CHECK_THAT(refuse(set, ExitCode::kBadFile), Contains("truncated"));
  fs::remove(set.input / "calibration/cam_to_cam.yaml");
  CHECK_THAT(refuse(set, ExitCode::kConfiguration), Contains("cam_to_cam.yaml"));
  fs::remove(set.events_file);
  CHECK_THAT(refuse(set, ExitCode::kFile), Contains("events/left/events.h5"));
}

TEST_CASE("DSEC: a filter that is nowhere installed is named") {
  const DsecSet set;
  // A filter that exists only while the file is written.
  static constexpr H5Z_filter_t kOwn = 32765;
  const auto same = [](unsigned, std::size_t, const unsigned*, std::size_t bytes, std::size_t*, void**) {
    return bytes;
  };
  const H5Z_class2_t own{H5Z_CLASS_T_VERS, kOwn, 1, 1, "own", nullptr, nullptr, same};
  REQUIRE(H5Zregister(&own) >= 0);
  set.write_events(kOwn);
  REQUIRE(H5Zunregister(kOwn) >= 0);
  CHECK_THAT(refuse(set, ExitCode::kFile), Contains("HDF5 filter 32765, whose plugin is missing"));

  if (!filter_available(kBlosc)) return;  // the test above says so
  set.write_events(kBlosc);
  H5Zunregister(kBlosc);
  REQUIRE(H5PLset_loading_state(0) >= 0);
  CHECK_THAT(refuse(set, ExitCode::kFile), Contains("compressed with Blosc") &&
                                               Contains("apt-get install hdf5-filter-plugin-blosc-serial"));
  REQUIRE(H5PLset_loading_state(H5PL_ALL_PLUGIN) >= 0);
}
