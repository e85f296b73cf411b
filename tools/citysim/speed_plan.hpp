// When a robot is where on its path: speed limits, comfortable accelerations, stops.
#pragma once

#include <vector>

#include "citysim/drive.hpp"
#include "citysim/drive_path.hpp"
#include "citysim/random.hpp"

namespace egofocus::citysim {

/// Progress along `path` each `step_s` from time `-lead_s`, `count` values, never falling. Two derivatives
/// are continuous; at a stop it is constant.
[[nodiscard]] std::vector<double> plan_progress(const DrivePath& path, const DriveStyle& style, double step_s,
                                                double lead_s, std::size_t count, sim::Random& random);

/// The mean over 2 * half + 1 values, twice: a kernel in the shape of a roof. Ends are held.
[[nodiscard]] std::vector<double> smoothed(const std::vector<double>& values, std::size_t half);

}  // namespace egofocus::citysim
