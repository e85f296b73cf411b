// The text sets of the event-camera data set and simulator (ECD, RPG) -> a recording folder.
//
//   events.txt or events_chunk.txt   t x y p
//   calib.txt                        fx fy cx cy k1 k2 p1 p2 k3
//   groundtruth.txt                  t px py pz qx qy qz qw
#pragma once

#include <filesystem>

#include "recording/conversion.hpp"

namespace egofocus::recording {

/// Without ConvertOptions::size: the smallest known sensor that fits events and calibration. `output` must
/// not hold anything; it appears whole or not at all. Throws Error.
ConvertReport convert_ecd(const std::filesystem::path& input, const std::filesystem::path& output,
                          const ConvertOptions& options);

}  // namespace egofocus::recording
