// What live devices count, as facts for health: names with the device's kind in front.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/socketcan_source.hpp"
#include "hal/usb_camera_counters.hpp"
#include "hal/v4l2_source.hpp"

namespace egofocus::daemon {

struct DeviceFact {
  const char* name;
  std::uint64_t value;
  bool is_counter = true;  ///< only ever grows
};

/// Append to `out`.
void tell(const UsbCameraCounters& counters, std::vector<DeviceFact>& out);
void tell(const V4l2CameraCounters& counters, std::vector<DeviceFact>& out);
void tell(const SocketCanHealth& health, std::vector<DeviceFact>& out);

}  // namespace egofocus::daemon
