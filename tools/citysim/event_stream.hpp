// The events of a file or a recording folder, whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "egofocus/types.hpp"
#include "hal/sensor_size.hpp"

namespace egofocus::citysim {

struct EventStream {
  SensorSize size;            ///< of text: the smallest known sensor that holds all events
  std::vector<Event> events;  ///< sorted by time, inside the sensor
  std::uint64_t dropped = 0;  ///< unreadable, out of range, or earlier than the event before
};

/// A folder with events.raw, a Prophesee RAW file, or text events. Throws recording::Error: kFile, kBadFile.
[[nodiscard]] EventStream read_event_stream(const std::filesystem::path& path);

}  // namespace egofocus::citysim
