#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "hal/pose_text_decoder.hpp"

using namespace egofocus;

namespace {

std::vector<PoseSample> decode(PoseTextDecoder& decoder, const std::string& text, std::size_t cut) {
  std::vector<PoseSample> poses;
  PoseSample out[2];
  std::size_t at = 0;
  for (const std::size_t end : {cut, text.size()}) {
    for (;;) {
      const auto bytes = std::as_bytes(std::span(text.data() + at, end - at));
      const Decoded done =
          end == text.size() && at >= cut ? decoder.finish(bytes, out) : decoder.feed(bytes, out);
      poses.insert(poses.end(), out, out + done.produced);
      at += done.consumed;
      if (done.consumed == 0) break;
    }
  }
  const auto rest = std::as_bytes(std::span(text.data() + at, text.size() - at));
  const Decoded done = decoder.finish(rest, out);
  poses.insert(poses.end(), out, out + done.produced);
  CHECK(at + done.consumed == text.size());
  return poses;
}

const std::string kText =
    "# t px py pz qx qy qz qw\n"
    "0.174156 0.1 -0.2 3e-1 0 0 0 1\n"
    "\r\n"
    "1.741570000000000000e-01\t1 2 3 0.5 0.5 -0.5 0.5\r\n"
    "0.2 1 2 3 0 0 0\n"
    "0.2 1 2 3 0 0 0 1 9\n"
    "0.2 1 nan 3 0 0 0 1\n"
    "0.2 1 1e999 3 0 0 0 1\n"
    "0.2 1 2 3 0 0 0 1.02\n"
    "0.2 1 2 3 0 0 0 0\n"
    "0.3 1 2 3 0 0 0.6 0.805\n"
    "0.25 1 2 3 0 0 0 -1";

}  // namespace

TEST_CASE("poses: numbers, comments, and every bad line counted, cut anywhere") {
  for (std::size_t cut = 0; cut <= kText.size(); ++cut) {
    PoseTextDecoder decoder;
    const std::vector<PoseSample> poses = decode(decoder, kText, cut);
    const PoseTextCounters& n = decoder.counters();
    REQUIRE(poses.size() == 4);
    CHECK(n.lines == 12);
    CHECK(n.poses == 4);
    CHECK(n.blank == 2);
    CHECK(n.malformed == 4);
    CHECK(n.bad_quaternion == 2);
    CHECK(n.over_long == 0);
    CHECK(n.out_of_order == 1);

    CHECK(poses[0].t_us == 174156);
    CHECK(poses[0].position_m[0] == 0.1);
    CHECK(poses[0].position_m[1] == -0.2);
    CHECK(poses[0].position_m[2] == 0.3);
    CHECK(poses[0].orientation_xyzw[3] == 1.0);
    CHECK(poses[1].t_us == 174157);
    CHECK(poses[1].orientation_xyzw[2] == -0.5);
    const double* q = poses[2].orientation_xyzw;
    CHECK(std::abs(q[2] * q[2] + q[3] * q[3] - 1.0) < 1e-15);
    CHECK(q[2] == Approx(0.6 / std::sqrt(0.36 + 0.805 * 0.805)));
    CHECK(poses[3].t_us == 250000);
  }
}

TEST_CASE("poses: a long line is skipped") {
  PoseTextDecoder decoder;
  const std::string text = std::string(5000, '1') + "\n0 0 0 0 0 0 0 1\n";
  CHECK(decode(decoder, text, 2000).size() == 1);
  CHECK(decoder.counters().over_long == 1);
}
