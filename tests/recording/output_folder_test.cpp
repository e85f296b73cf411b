#include "recording/output_folder.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "recording/error.hpp"
#include "recording/rigid_transform.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"
#include "recording/whole_file.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using Catch::Matchers::Contains;

namespace fs = std::filesystem;

TEST_CASE("an output appears whole or not at all") {
  const TemporaryFolder at;
  {
    OutputFolder output(at / "out");
    output.create();
    write_text_file(output / "events.raw", "half");
    CHECK_FALSE(fs::exists(at / "out"));
    CHECK(fs::exists(at / "out.partial/events.raw"));
  }
  CHECK(fs::is_empty(at.path()));

  fs::create_directory(at / "out.partial");
  write_text_file(at / "out.partial/left_by_a_killed_run", "");
  OutputFolder output(at.path() / "out/");
  output.create();
  write_text_file(output / "events.raw", "whole");
  output.finish();
  CHECK(fs::exists(at / "out/events.raw"));
  CHECK_FALSE(fs::exists(at / "out/left_by_a_killed_run"));
  CHECK_FALSE(fs::exists(at / "out.partial"));
}

TEST_CASE("an output that holds something is refused") {
  const TemporaryFolder at;
  fs::create_directory(at / "out");
  CHECK_NOTHROW(OutputFolder(at / "out"));
  write_text_file(at / "out/letter.txt", "");
  CHECK_THROWS_WITH(OutputFolder(at / "out"), Contains("no empty folder"));
  write_text_file(at / "out/events.raw", "");
  CHECK_THROWS_WITH(OutputFolder(at / "out"), Contains("already holds a recording"));
  write_text_file(at / "file", "");
  CHECK_THROWS_WITH(OutputFolder(at / "file"), Contains("no empty folder"));
}

TEST_CASE("an output where nobody may write is a message") {
  const TemporaryFolder at;
  write_text_file(at / "file", "");
  OutputFolder below(at / "file/out");
  CHECK_THROWS_WITH(below.create(), Contains("cannot be made"));
}

TEST_CASE("a file appears whole or not at all") {
  const TemporaryFolder at;
  write_text_file(at / "file", "old");
  fs::create_symlink("file", at / "link");
  {
    WholeFile file(at / "link");
    file.write("half");
    CHECK(read_text_file(at / "file") == "old");
  }
  CHECK(read_text_file(at / "file") == "old");
  WholeFile file(at / "link");
  file.write("who");
  file.write("le");
  file.finish();
  CHECK(read_text_file(at / "file") == "whole");
  CHECK(fs::is_symlink(at / "link"));
  CHECK(std::distance(fs::directory_iterator(at.path()), {}) == 2);
  CHECK_THROWS_WITH(WholeFile(at / "no/file"), Contains("No such file or directory"));
  CHECK_THROWS_WITH(write_text_file(at.path(), "a folder"), Contains("cannot be written"));
}

TEST_CASE("rotations become quaternions of any angle") {
  // Axis and angle -> matrix by Rodrigues, and the quaternion that belongs to them.
  const double axes[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.6, -0.48, 0.64}};
  for (const auto& n : axes) {
    for (const double angle : {0.0, 0.3, 1.5, 3.1, std::numbers::pi}) {
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      const double v = 1 - c;
      RigidTransform turn;
      turn.rotation = {c + n[0] * n[0] * v,        n[0] * n[1] * v - n[2] * s, n[0] * n[2] * v + n[1] * s,
                       n[1] * n[0] * v + n[2] * s, c + n[1] * n[1] * v,        n[1] * n[2] * v - n[0] * s,
                       n[2] * n[0] * v - n[1] * s, n[2] * n[1] * v + n[0] * s, c + n[2] * n[2] * v};
      const PoseSample pose = pose_of(7, turn);
      CHECK(pose.orientation_xyzw[3] == Approx(std::cos(angle / 2)).margin(1e-9));
      for (std::size_t i = 0; i < 3; ++i) {
        CHECK(pose.orientation_xyzw[i] == Approx(n[i] * std::sin(angle / 2)).margin(1e-9));
      }
      CHECK(is_rotation(turn.rotation));
      turn.translation_m = {1, -2, 3};
      const RigidTransform none = turn * inverse(turn);
      CHECK(none.rotation[0] == Approx(1));
      for (std::size_t i = 0; i < 3; ++i) CHECK(none.translation_m[i] == Approx(0).margin(1e-12));
    }
  }
  CHECK_FALSE(is_rotation({1, 0, 0, 0, 1, 0, 0, 0, -1}));  // a mirror
  CHECK_FALSE(is_rotation({0, 0, 0, 0, 0, 0, 0, 0, 0}));
}
