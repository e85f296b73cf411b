// poses.txt: one camera pose a line, `t px py pz qx qy qz qw`; seconds, metres, unit quaternion.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "egofocus/types.hpp"

namespace egofocus::recording {

/// Blank lines and lines that begin with # are skipped. Throws Error (kBadFile) with the line number on a
/// line that does not hold eight finite numbers, on a time that does not rise, and on a quaternion whose
/// length is not 1 +- 0.01 (it is then normalised exactly). Times round to the nearest microsecond.
[[nodiscard]] std::vector<PoseSample> parse_poses(std::string_view text, const std::string& name);

/// Throws Error (kMotion) when two neighbours lie further apart than the limit; the message names both times.
/// What lies before the first pose or after the last one is no gap.
void check_pose_gaps(const std::vector<PoseSample>& poses, std::int64_t max_gap_us, const std::string& name);

/// The text of a pose file: positions read back as the same bits, quaternions to one rounding.
[[nodiscard]] std::string poses_text(const std::vector<PoseSample>& poses);

}  // namespace egofocus::recording
