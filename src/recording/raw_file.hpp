// events.raw as a whole: writing one, and reading one for inspection (a replay streams it instead).
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "egofocus/types.hpp"
#include "hal/sensor_size.hpp"

namespace egofocus::recording {

/// A Prophesee RAW file in EVT3. The events must be sorted by time, with t >= 0 and inside the sensor; throws
/// Error (kInternal) if the encoder refuses any.
[[nodiscard]] std::vector<std::byte> raw_file_bytes(std::span<const Event> events, SensorSize size);

/// Writes bytes as they are. Throws Error (kFile).
void write_raw_file(const std::filesystem::path& path, std::span<const Event> events, SensorSize size);

}  // namespace egofocus::recording
