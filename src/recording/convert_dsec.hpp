// DSEC, the stereo event camera data set for driving -> a recording folder.
//
//   events/left/events.h5 or events_left/events.h5    /events/{t, x, y, p}, /t_offset; microseconds
//   calibration/cam_to_cam.yaml or cam_to_cam.yaml    cam0 raw, camRect0 rectified, R_rect0, cams_03 (Q)
//   disparity/event/*.png, disparity/timestamps.txt   disparity * 256 on the rectified left event view
//
// The left camera, raw events; the truth is carried from the rectified view to the raw camera's undistorted
// grid. There are no poses in the set: ConvertOptions::poses. Source: the data set's page "Data Format".
#pragma once

#include <filesystem>

#include "recording/conversion.hpp"

namespace egofocus::recording {

/// `input` is the folder of a sequence. Disparity may be missing. Throws Error.
ConvertReport convert_dsec(const std::filesystem::path& input, const std::filesystem::path& output,
                           const ConvertOptions& options);

/// The events file of such a folder; empty when there is none.
[[nodiscard]] std::filesystem::path find_dsec_events(const std::filesystem::path& input);

}  // namespace egofocus::recording
