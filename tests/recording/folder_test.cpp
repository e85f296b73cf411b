#include "recording/folder.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "recording/error.hpp"
#include "recording/png_io.hpp"
#include "recording/pose_file.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using Catch::Matchers::Contains;

namespace {

const std::string kToml =
    "[camera]\nwidth_px = 24\nheight_px = 18\nfx_px = 20\nfy_px = 20\ncx_px = 12\ncy_px = 9\n"
    "[motion]\nsource = \"poses\"\nmax_pose_gap_us = 50000\n";
const std::string kPoses =
    "# comment\n0.00 0 0 0 0 0 0 1\n\n0.05 1 0 0 0 0 0 1\r\n0.10 2 0 0 0 0.7071067811865476 0 "
    "0.7071067811865476\n";

struct Recording : TemporaryFolder {
  Recording() {
    put("camera.toml", kToml);
    put("poses.txt", kPoses);
    put("events.raw", "% evt 3.0\n% end\n");
  }
  void put(const std::string& name, const std::string& text) const { write_text_file(*this / name, text); }

  [[nodiscard]] std::string complaint(ExitCode code) const {
    try {
      (void)open_folder(path());
    } catch (const Error& error) {
      CHECK(error.exit_code() == static_cast<int>(code));
      return error.what();
    }
    return "no complaint";
  }
};

}  // namespace

TEST_CASE("a whole recording opens") {
  Recording recording;
  std::filesystem::create_directories(recording / "depth");
  recording.put("depth/000000050000.png", "");
  recording.put("depth/000000000000.png", "");
  const Folder folder = open_folder(recording.path());
  CHECK(folder.poses.size() == 3);
  CHECK(folder.poses[1].t_us == 50000);
  CHECK(folder.poses[1].position_m[0] == 1.0);
  CHECK(folder.events.text().substr(0, 5) == "% evt");
  REQUIRE(folder.truth.size() == 2);
  CHECK(folder.truth[0].t_us == 0);
  CHECK(folder.truth_at(50000) == &folder.truth[1]);
  CHECK(folder.truth_at(49999) == nullptr);
  CHECK(is_recording(recording.path()));
  CHECK(depth_name(123) == "depth/000000000123.png");
}

TEST_CASE("each missing file is named") {
  Recording recording;
  for (const std::string name : {"events.raw", "camera.toml"}) {
    Recording damaged;
    std::filesystem::remove(damaged / name);
    CHECK_THAT(damaged.complaint(ExitCode::kFile), Contains(name));
  }
  try {
    (void)open_folder(recording / "nowhere");
    FAIL("opened a folder that is not there");
  } catch (const Error& error) {
    CHECK(error.exit_code() == static_cast<int>(ExitCode::kFile));
    CHECK_THAT(error.what(), Contains("nowhere: is no recording folder"));
  }
  recording.put("events.raw", "");
  CHECK_THAT(recording.complaint(ExitCode::kNoEvents), Contains("events.raw: is empty"));
}

TEST_CASE("a recording without motion says what to add") {
  Recording recording;
  std::filesystem::remove(recording / "poses.txt");
  CHECK_THAT(recording.complaint(ExitCode::kMotion), Contains("no motion") && Contains("poses.txt"));

  const std::string odometry = kToml.substr(0, kToml.find("[motion]"));
  recording.put("camera.toml", odometry);
  CHECK_THAT(recording.complaint(ExitCode::kConfiguration), Contains("[can] names no signals"));

  recording.put("camera.toml", odometry +
                                   "[can]\ndbc = \"v.dbc\"\n[[can.signals]]\nmessage = \"M\"\nsignal = "
                                   "\"S\"\nrole = \"wheel_speed\"\n");
  CHECK_THAT(recording.complaint(ExitCode::kFile), Contains("v.dbc: cannot be opened"));
  recording.put("v.dbc", "BO_ 1 M: 8 X\n");
  CHECK_THAT(recording.complaint(ExitCode::kMotion), Contains("can.log is missing or empty"));
  recording.put("can.log", "(0.0) can0 001#00\n");
  CHECK(recording.complaint(ExitCode::kMotion) == "no complaint");
}

TEST_CASE("poses are refused with their line") {
  Recording recording;
  recording.put("poses.txt", kPoses + "0.2 0 0\n");
  CHECK_THAT(recording.complaint(ExitCode::kBadFile), Contains("poses.txt:6: is no pose"));
  recording.put("poses.txt", kPoses + "0.14 0 0 0 1 1 1 1\n");
  CHECK_THAT(recording.complaint(ExitCode::kBadFile),
             Contains("poses.txt:6: the quaternion's length is not 1"));
  recording.put("poses.txt", kPoses + "0.09 0 0 0 0 0 0 1\n");
  CHECK_THAT(recording.complaint(ExitCode::kBadFile), Contains("0.090000 s after 0.100000 s"));
  recording.put("poses.txt", kPoses + "0.150001 0 0 0 0 0 0 1\n");
  CHECK_THAT(recording.complaint(ExitCode::kMotion),
             Contains("no pose between 0.100000 s and 0.150001 s") && Contains("max_pose_gap_us"));
  recording.put("poses.txt", "0 0 0 0 0 0 0 1\n");
  CHECK_THAT(recording.complaint(ExitCode::kMotion), Contains("fewer than two"));
  recording.put("poses.txt", kPoses + std::string(2000, '1') + "\n");
  CHECK_THAT(recording.complaint(ExitCode::kBadFile), Contains("poses.txt:6"));
}

TEST_CASE("the poses that are written read back") {
  std::vector<PoseSample> poses = parse_poses(kPoses, "poses.txt");
  const std::vector<PoseSample> again = parse_poses(poses_text(poses), "again");
  REQUIRE(again.size() == poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    CHECK(again[i].t_us == poses[i].t_us);
    CHECK(again[i].position_m[0] == poses[i].position_m[0]);
    CHECK(again[i].orientation_xyzw[1] == Approx(poses[i].orientation_xyzw[1]).margin(1e-9));
  }
}

TEST_CASE("truth must fit the grid") {
  if (!png_available()) return;
  Recording recording;
  std::filesystem::create_directories(recording / "depth");
  Grey16Picture picture(24, 18, 1500);
  picture.at(0, 0) = 0;
  picture.at(1, 0) = 65535;
  picture.at(2, 0) = 65534;
  write_png(recording / "depth/000000000100.png", picture);
  write_png(recording / "depth/000000000200.png", Grey16Picture(24, 17, 1500));
  const Folder folder = open_folder(recording.path());
  const Picture<float> depth = read_depth(folder.truth[0], folder.camera);
  CHECK(depth.at(3, 4) == 1.5f);
  CHECK(depth.at(0, 0) == 0.0f);
  CHECK(depth.at(1, 0) == std::numeric_limits<float>::infinity());
  CHECK(depth.at(2, 0) == 65.534f);
  CHECK_THROWS_WITH((void)read_depth(folder.truth[1], folder.camera),
                    Contains("is 24x17 px") && Contains("24x18"));
}
