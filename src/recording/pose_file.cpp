#include "recording/pose_file.hpp"

#include "core/elementary.hpp"
#include "recording/error.hpp"
#include "recording/number_text.hpp"

namespace egofocus::recording {
namespace {

constexpr double kLengthTolerance = 0.01;
constexpr double kLargest = 1e9;

bool finite(double value) {
  return value > -kLargest && value < kLargest;
}

[[noreturn]] void fail(const std::string& name, std::int64_t line, const std::string& what) {
  throw Error(ExitCode::kBadFile, name + ":" + std::to_string(line), what);
}

PoseSample parse_line(std::string_view line, const std::string& name, std::int64_t number) {
  PoseSample pose;
  double values[7];
  std::string_view rest = line;
  bool good = parse_seconds(take_word(rest), pose.t_us);
  for (double& value : values) good = good && parse_number(take_word(rest), value) && finite(value);
  if (!good || !take_word(rest).empty()) {
    fail(name, number, "a pose line holds eight numbers `t px py pz qx qy qz qw`; this one does not.");
  }
  double length = 0;
  for (int i = 3; i < 7; ++i) length += values[i] * values[i];
  length = square_root(length);
  if (absolute(length - 1.0) > kLengthTolerance) {
    fail(name, number,
         "the quaternion has length " + number_text(length) +
             "; it must be 1. Is the column order qx qy qz qw?");
  }
  for (int i = 0; i < 3; ++i) pose.position_m[i] = values[i];
  for (int i = 0; i < 4; ++i) pose.orientation_xyzw[i] = values[3 + i] / length;
  return pose;
}

}  // namespace

std::vector<PoseSample> parse_poses(std::string_view text, const std::string& name) {
  std::vector<PoseSample> poses;
  for (std::int64_t number = 1; !text.empty(); ++number) {
    const std::string_view line = take_line(text);
    std::string_view peek = line;
    const std::string_view first = take_word(peek);
    if (first.empty() || first[0] == '#') continue;
    const PoseSample pose = parse_line(line, name, number);
    if (!poses.empty() && pose.t_us <= poses.back().t_us) {
      fail(name, number,
           "time goes backwards or stands still: " + seconds_text(pose.t_us) + " s after " +
               seconds_text(poses.back().t_us) + " s. Sort the file.");
    }
    poses.push_back(pose);
  }
  return poses;
}

void check_pose_gaps(const std::vector<PoseSample>& poses, std::int64_t max_gap_us, const std::string& name) {
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const std::int64_t gap_us = poses[i].t_us - poses[i - 1].t_us;
    if (gap_us <= max_gap_us) continue;
    throw Error(ExitCode::kMotion, name,
                "no pose between " + seconds_text(poses[i - 1].t_us) + " s and " +
                    seconds_text(poses[i].t_us) + " s; " + std::to_string(max_gap_us) +
                    " us are allowed. Fill the gap, cut the recording there, or raise " +
                    "[motion] max_pose_gap_us in camera.toml.");
  }
}

std::string poses_text(const std::vector<PoseSample>& poses) {
  std::string text = "# t_s px_m py_m pz_m qx qy qz qw (camera in the world)\n";
  for (const PoseSample& pose : poses) {
    text += seconds_text(pose.t_us);
    for (const double value : pose.position_m) text += " " + number_text(value);
    for (const double value : pose.orientation_xyzw) text += " " + number_text(value);
    text += "\n";
  }
  return text;
}

}  // namespace egofocus::recording
