// poses.txt: one camera pose a line, `t px py pz qx qy qz qw`; seconds, metres, unit quaternion.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "egofocus/types.hpp"

namespace egofocus::recording {

/// Blank lines and comments (#) are skipped. Where a live stream counts and goes on, a file is refused:
/// throws Error (kBadFile) with the line number if a line is no pose, its quaternion has no length of 1 +-
/// 0.01, or time does not rise.
[[nodiscard]] std::vector<PoseSample> parse_poses(std::string_view text, const std::string& name);

/// Throws Error (kMotion) when two neighbours lie further apart than the limit; the message names both times.
/// What lies before the first pose or after the last one is no gap.
void check_pose_gaps(const std::vector<PoseSample>& poses, std::int64_t max_gap_us, const std::string& name);

/// The text of a pose file, with nine decimals (a nanometre).
[[nodiscard]] std::string poses_text(const std::vector<PoseSample>& poses);

}  // namespace egofocus::recording
