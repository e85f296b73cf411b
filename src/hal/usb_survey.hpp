// Which event cameras are on the bus, and what keeps each from being used.
#pragma once

#include <cstddef>
#include <span>

#include "hal/usb_camera.hpp"

namespace egofocus {

/// One camera. `status`: ok, or why it cannot be used: kNoPermission, kDeviceBusy, kUnknownFirmware,
/// kUnsupportedDevice, kDeviceLost, kIo.
struct UsbSighting {
  UsbCameraInfo info;  ///< as far as it got
  Status status;
  bool has_slow_link = false;  ///< usable, but on USB 2 where it could do USB 3
};

/// Opens each known device for a moment, starts nothing. `found` may exceed the span: only that many are told
/// of. kIo when the bus itself cannot be read. Thread: one. RT: no.
Status survey_usb(const UsbIo& io, std::span<UsbSighting> out, std::size_t& found) noexcept;

}  // namespace egofocus
