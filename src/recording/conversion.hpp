// What every conversion into a recording folder takes and reports.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hal/sensor_size.hpp"

namespace egofocus::recording {

enum class CameraSide : std::uint8_t { kLeft, kRight };

struct ConvertOptions {
  std::optional<SensorSize> size;     ///< without it: what the input or its calibration says
  std::optional<std::int64_t> t0_us;  ///< subtracted from all times; without it: see ConvertReport::t0_us
  double z_near_m = 0.5;              ///< [ladder] z_near_m of the new camera.toml
  std::filesystem::path kalibr;       ///< a Kalibr camchain; empty: what lies beside the input, if anything
  std::filesystem::path poses;        ///< poses of the event camera on the input's clock; empty: the input's
  CameraSide camera = CameraSide::kLeft;
  std::function<void(std::size_t, std::size_t)> progress;  ///< done, all
};

/// What was done, and all that was left out. Each event read is in `events` or in one of the dropped kinds.
struct ConvertReport {
  SensorSize size;
  std::int64_t t0_us = 0;  ///< 0, or the first event's whole second if that is later than an hour (an epoch)
  std::uint64_t events = 0;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
  std::uint64_t malformed = 0;     ///< no event: not a number, or a time that cannot be
  std::uint64_t out_of_order = 0;  ///< earlier than the event before
  std::uint64_t out_of_range = 0;  ///< outside the sensor
  std::uint64_t before_t0 = 0;
  std::uint64_t poses = 0;
  std::uint64_t poses_dropped = 0;        ///< not later than the pose before, or no rotation
  std::int64_t widest_pose_gap_us = 0;    ///< camera.toml's max_pose_gap_us is the limit of a replay
  std::uint64_t events_before_poses = 0;  ///< kept; no depth can rest on them
  std::uint64_t events_after_poses = 0;
  std::uint64_t imu_samples = 0;
  std::uint64_t imu_dropped = 0;  ///< before t0, not later than the sample before, or not finite
  std::uint64_t depth_pictures = 0;
  std::uint64_t depth_dropped = 0;       ///< pictures before t0, or not later than the one before
  std::uint64_t depth_out_of_scale = 0;  ///< pixels too far for 16 bits: unknown in the recording
  std::vector<std::string> left_out;     ///< inputs that carry nothing for a recording, such as imu.txt
  std::vector<std::string> remarks;      ///< what the user must know before a replay
};

}  // namespace egofocus::recording
