// By how much an IMU's samples come late, seen from the events: gyro and events tell of the same rotation.
#pragma once

#include <cstdint>
#include <string>

#include "recording/folder.hpp"

namespace egofocus::recording {

struct TimeOffset {
  double late_ms = 0;             ///< gyro samples, as [can] stamps them, after the motion that they tell of
  double sigma_ms = 0;            ///< 1-sigma, from the parts of the recording taken alone
  double correlation = 0;         ///< of the two rotations at that offset, 0..1
  double rotation_rad_s = 0;      ///< rms of what of the gyro was compared: changes within half a second
  std::int64_t imu_delay_us = 0;  ///< what [can] should say: what it says now, and late_ms
  std::int64_t old_imu_delay_us = 0;
  std::size_t windows = 0;  ///< that were compared
  /// Empty, or why not to trust it.
  std::string doubt;
};

/// Looks at offsets of up to range_ms (5..200) either way. Rotates the gyro by [motion] camera_from_body,
/// takes windows of 20 ms, and correlates what changes within half a second: a bias of the gyro, and the part
/// of the events' rotation that is the camera's translation, fall out. Throws Error: kMotion without a CAN
/// log or a gyro in it, or with less than a second of both; those of open_folder() and make_can_decoder().
[[nodiscard]] TimeOffset estimate_time_offset(const Folder& folder, double range_ms);

}  // namespace egofocus::recording
