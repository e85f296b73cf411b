#include "fuzz/text_fuzz.hpp"
#include "hal/pose_text_decoder.hpp"

using namespace egofocus;
using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto same = [](const PoseSample& a, const PoseSample& b) {
    return a.t_us == b.t_us && std::memcmp(a.position_m, b.position_m, sizeof a.position_m) == 0 &&
           std::memcmp(a.orientation_xyzw, b.orientation_xyzw, sizeof a.orientation_xyzw) == 0;
  };
  fuzz::decode_text<PoseSample, PoseTextDecoder>(
      data, size, same, [](const std::vector<PoseSample>& poses, const PoseTextCounters& n) {
        require(n.poses == poses.size());
        require(n.poses + n.blank + n.malformed + n.bad_quaternion + n.over_long == n.lines);
        for (const PoseSample& pose : poses) {
          double norm = 0;
          for (const double q : pose.orientation_xyzw) norm += q * q;
          require(norm > 1 - 1e-12 && norm < 1 + 1e-12);
          for (const double p : pose.position_m) require(p - p == 0);
        }
      });
  return 0;
}
