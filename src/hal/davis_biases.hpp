// The biases of the DAVIS chips with the values that libcaer starts with.
#pragma once

#include <cstdint>
#include <span>

#include "egofocus/status.hpp"
#include "hal/usb_camera.hpp"

namespace egofocus {

/// Appends all biases of a chip, those of `settings` in place of the default ones. `is_346`: DAVIS346, else
/// DAVIS240. kBadDeviceSetting: a name that the chip lacks, a voltage (frames only, not for users), a code
/// out of range, or coarse or fine alone. Source: libcaer, src/davis.c and include/libcaer/devices/davis.h.
/// Thread: any. RT: yes.
Status add_davis_biases(bool is_346, const UsbCameraSettings& settings, UsbSteps& steps) noexcept;

}  // namespace egofocus
