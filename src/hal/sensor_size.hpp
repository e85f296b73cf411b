// The pixel array of a sensor: what its addresses are checked against.
#pragma once

#include <cstdint>

namespace egofocus {

struct SensorSize {
  std::uint16_t width_px = 0;
  std::uint16_t height_px = 0;
};

}  // namespace egofocus
