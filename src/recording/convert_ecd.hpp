// The text sets of the event-camera data set and simulator (ECD, RPG) -> a recording folder.
//
//   events.txt or events_chunk.txt   t x y p
//   calib.txt                        fx fy cx cy k1 k2 p1 p2 k3
//   groundtruth.txt                  t px py pz qx qy qz qw
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hal/sensor_size.hpp"

namespace egofocus::recording {

struct EcdOptions {
  std::optional<SensorSize> size;  ///< without it: the smallest known sensor that fits events and calibration
  std::optional<std::int64_t> t0_us;  ///< subtracted from all times; without it: see EcdReport::t0_us
  double z_near_m = 0.5;              ///< [ladder] z_near_m of the new camera.toml
  std::function<void(std::size_t, std::size_t)> progress;
};

/// What was done, and all that was left out.
struct EcdReport {
  SensorSize size;
  std::int64_t t0_us = 0;  ///< 0, or the first event's whole second if that is later than an hour (an epoch)
  std::uint64_t events = 0;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
  std::uint64_t malformed = 0;
  std::uint64_t out_of_order = 0;
  std::uint64_t out_of_range = 0;
  std::uint64_t before_t0 = 0;
  std::uint64_t poses = 0;
  std::uint64_t events_before_poses = 0;  ///< kept; no depth can rest on them
  std::uint64_t events_after_poses = 0;
  std::vector<std::string> left_out;  ///< files that carry nothing for a recording, such as imu.txt
};

/// Writes events.raw (EVT3), poses.txt and camera.toml into `output`, which is made if needed; a recording
/// that is already there is refused. Throws Error.
EcdReport convert_ecd(const std::filesystem::path& input, const std::filesystem::path& output,
                      const EcdOptions& options);

}  // namespace egofocus::recording
