// events.raw, written piece by piece: a recording of any length needs the memory of one block.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

#include "egofocus/types.hpp"
#include "hal/evt3_encoder.hpp"
#include "hal/sensor_size.hpp"

namespace egofocus::recording {

class EventFile {
 public:
  /// Creates the file with its header. Throws Error (kFile).
  EventFile(std::filesystem::path path, SensorSize size);

  /// Sorted by time over all calls, t >= 0, inside the sensor; throws Error: kInternal when the encoder
  /// refuses one, kFile when the disk does.
  void write(std::span<const Event> events);

  /// Throws Error (kFile) when not all could be written.
  void close();

 private:
  void put(std::size_t bytes);

  std::filesystem::path path_;
  std::ofstream file_;
  Evt3Encoder encoder_;
  std::vector<std::byte> block_;
};

}  // namespace egofocus::recording
