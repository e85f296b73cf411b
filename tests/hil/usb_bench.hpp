// The USB camera source over the real libusb and kernel.
#pragma once

#include <cstdio>

#include "hal/usb_camera_source.hpp"
#include "hal/usb_survey.hpp"
#include "hil/camera_bench.hpp"

namespace egofocus::hil {

struct Bench : CameraBench<UsbCameraSource> {
  explicit Bench(const UsbCameraSettings& settings)
      : CameraBench(settings, *system_usb(), monotonic_clock()) {}
};

inline Status survey_one() {
  UsbSighting sighting;
  std::size_t found = 0;
  if (const Status status = survey_usb(*system_usb(), {&sighting, 1}, found); !status.ok()) return status;
  if (found != 1) return {StatusCode::kNoDevice, "survey", static_cast<std::int64_t>(found)};
  std::printf("       %s, serial %s, %s\n", sighting.info.name, sighting.info.serial,
              sighting.status.ok() ? "ready" : sighting.status.subject());
  return sighting.status;
}

}  // namespace egofocus::hil
