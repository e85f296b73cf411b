#include "recording/pose_file.hpp"

#include <algorithm>
#include <span>

#include "hal/pose_text_decoder.hpp"
#include "recording/error.hpp"
#include "recording/number_text.hpp"

namespace egofocus::recording {
namespace {

[[noreturn]] void fail(const std::string& name, std::int64_t line, const std::string& what) {
  throw Error(ExitCode::kBadFile, name + ":" + std::to_string(line), what);
}

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace

std::vector<PoseSample> parse_poses(std::string_view text, const std::string& name) {
  std::vector<PoseSample> poses;
  PoseTextDecoder decoder;
  // One line at a time, so that a complaint can name it.
  for (std::int64_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    PoseSample pose;
    std::span<const std::byte> rest = bytes_of(line);
    std::size_t produced = 0;
    while (!rest.empty() && produced == 0) {
      const Decoded step = decoder.finish(rest, std::span(&pose, 1));
      rest = rest.subspan(step.consumed);
      produced = step.produced;
    }
    const PoseTextCounters& counters = decoder.counters();
    if (counters.malformed > 0 || counters.over_long > 0) {
      fail(name, number,
           "is no pose: eight numbers `t px py pz qx qy qz qw` are needed. Correct or remove the line.");
    }
    if (counters.bad_quaternion > 0) {
      fail(name, number, "the quaternion's length is not 1. Is the order of the columns qx qy qz qw?");
    }
    if (produced == 0) continue;
    if (!poses.empty() && pose.t_us <= poses.back().t_us) {
      fail(name, number,
           "time goes backwards or stands still: " + seconds_text(pose.t_us) + " s after " +
               seconds_text(poses.back().t_us) + " s. Sort the file by time.");
    }
    poses.push_back(pose);
  }
  return poses;
}

void check_pose_gaps(const std::vector<PoseSample>& poses, std::int64_t max_gap_us, const std::string& name) {
  for (std::size_t i = 1; i < poses.size(); ++i) {
    if (poses[i].t_us - poses[i - 1].t_us <= max_gap_us) continue;
    throw Error(ExitCode::kMotion, name,
                "no pose between " + seconds_text(poses[i - 1].t_us) + " s and " +
                    seconds_text(poses[i].t_us) + " s, and only " + std::to_string(max_gap_us) +
                    " us are allowed. Fill the gap, cut the recording there, or raise [motion] " +
                    "max_pose_gap_us in camera.toml.");
  }
}

std::string poses_text(const std::vector<PoseSample>& poses) {
  std::string text = "# t_s px_m py_m pz_m qx qy qz qw (camera in the world)\n";
  for (const PoseSample& pose : poses) {
    text += seconds_text(pose.t_us);
    for (const double value : pose.position_m) text += " " + fixed_text(value, 9);
    for (const double value : pose.orientation_xyzw) text += " " + fixed_text(value, 9);
    text += "\n";
  }
  return text;
}

}  // namespace egofocus::recording
