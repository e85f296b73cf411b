// What is the same for every layout: which one it is, and what the file system refuses.
#include "recording/convert.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>

#include "recording/converted.hpp"
#include "recording/event_file.hpp"
#include "recording/imu_log.hpp"
#include "recording/pose_file.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using namespace egofocus::test;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

namespace {

/// A user without rights, as long as it lives: to root nothing is forbidden.
struct Nobody {
  Nobody() : was_root(geteuid() == 0 && seteuid(65534) == 0) {}
  ~Nobody() {
    if (was_root && seteuid(0) != 0) std::abort();
  }
  bool was_root;
};

std::string message_of_guess(const fs::path& input) {
  try {
    (void)guess_format(input);
  } catch (const Error& error) {
    CHECK(error.exit_code() == static_cast<int>(ExitCode::kFile));
    return error.what();
  }
  return "no complaint";
}

}  // namespace

TEST_CASE("layouts have names") {
  CHECK(input_format_of("mvsec") == InputFormat::kMvsec);
  CHECK(input_format_of("aedat4") == InputFormat::kAedat4);
  CHECK_FALSE(input_format_of("rosbag").has_value());
}

TEST_CASE("a layout is recognised by what it holds") {
  const TemporaryFolder at;
  CHECK(guess_format(at.path()) == InputFormat::kEcd);
  write_text_file(at / "x_data.hdf5", "");
  CHECK(guess_format(at.path()) == InputFormat::kMvsec);
  fs::create_directory(at / "events_left");
  write_text_file(at / "events_left/events.h5", "");
  CHECK(guess_format(at.path()) == InputFormat::kDsec);
  write_text_file(at / "a", "#!AER-DAT4.0\r\n");
  CHECK(guess_format(at / "a") == InputFormat::kAedat4);
  write_text_file(at / "h", "\x89HDF\r\n\x1a\n");
  CHECK(guess_format(at / "h") == InputFormat::kMvsec);
}

TEST_CASE("files that may not be read, and folders that may not be written, are a message") {
  const TemporaryFolder at;
  fs::create_directory(at / "closed");
  for (const char* name : {"secret.aedat4", "secret_data.hdf5"}) {
    write_text_file(at / name, "#!AER-DAT4.0\r\n");
    fs::permissions(at / name, fs::perms::none);
  }
  fs::create_directory(at / "ecd");
  write_text_file(at / "ecd/events.txt", "0.1 10 20 1\n");
  write_text_file(at / "ecd/calib.txt", "199.5 200 120 90\n");
  write_text_file(at / "ecd/groundtruth.txt", "0.0 0 0 0 0 0 0 1\n0.2 1 0 0 0 0 0 1\n");
  fs::create_directory(at / "own");
  fs::permissions(at / "own", fs::perms::all);
  fs::permissions(at / "closed", fs::perms::none);
  fs::permissions(at.path(), fs::perms::owner_read | fs::perms::owner_exec | fs::perms::group_exec |
                                 fs::perms::others_exec);
  {
    const Nobody nobody;
    const fs::path out = at / "own/out";
    CHECK_THAT(complaint(ExitCode::kFile, InputFormat::kAedat4, at / "secret.aedat4", out),
               Contains("Permission denied"));
    CHECK_THAT(complaint(ExitCode::kFile, InputFormat::kMvsec, at / "secret_data.hdf5", out),
               Contains("secret_data.hdf5: cannot be opened. Check the path and the permissions"));
    CHECK_THAT(message_of_guess(at / "secret.aedat4"), Contains("cannot be opened"));
    CHECK_THAT(message_of_guess(at / "closed"), Contains("Permission denied"));
    CHECK_THAT(complaint(ExitCode::kFile, InputFormat::kEcd, at / "ecd", at / "out"),
               Contains("out.partial: cannot be made (Permission denied)"));
    CHECK(convert(InputFormat::kEcd, at / "ecd", out, {}).events == 1);
  }
  fs::permissions(at.path(), fs::perms::owner_all);
  fs::permissions(at / "closed", fs::perms::owner_all);
}

TEST_CASE("a full disk is a message") {
  if (!fs::exists("/dev/full")) return;
  const auto fill = [] {
    EventFile file("/dev/full", {320, 240});
    file.write(some_events(100000, 320, 240, 5));
    file.close();
  };
  CHECK_THROWS_WITH(fill(), Contains("is the disk full?"));
  ImuLog log("/dev/full");
  CHECK_THROWS_WITH((log.write({}), log.close()), Contains("is the disk full?"));
}

TEST_CASE("poses of the user's own, moved to the same origin as the events") {
  const TemporaryFolder at;
  write_text_file(at / "events.txt", "100.1 10 20 1\n100.2 11 20 0\n");
  write_text_file(at / "calib.txt", "199.5 200 120 90\n");
  write_text_file(at / "other.txt", "100.125 4 0 0 0 0 0 1\n100.15 5 0 0 0 0 0 1\n100.35 6 0 0 0 0 0 1\n");
  ConvertOptions options;
  options.t0_us = 100150000;
  options.poses = at / "other.txt";
  const ConvertReport report = convert(InputFormat::kEcd, at.path(), at / "out", options);
  CHECK(report.events == 1);
  CHECK(report.before_t0 == 1);
  CHECK(report.first_us == 50000);
  CHECK(report.events_before_poses == 1);
  CHECK(report.widest_pose_gap_us == 200000);
  REQUIRE(report.remarks.size() == 1);
  CHECK_THAT(report.remarks[0], Contains("max_pose_gap_us"));
  const std::vector<PoseSample> poses = parse_poses(read_text_file(at / "out/poses.txt"), "poses.txt");
  REQUIRE(poses.size() == 3);
  CHECK(poses[0].t_us == -25000);
  CHECK(poses[1].t_us == 0);
  CHECK(poses[1].position_m[0] == 5.0);
}
