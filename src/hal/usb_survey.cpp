#include "hal/usb_survey.hpp"

#include "hal/device_status.hpp"

#include <array>

namespace egofocus {

Status survey_usb(const UsbIo& io, std::span<UsbSighting> out, std::size_t& found) noexcept {
  found = 0;
  UsbConnection usb;
  if (const int error = usb.open_bus(io); error != 0) return device_status(error, "the USB bus");
  std::array<UsbDevice, 128> devices;
  const std::size_t all = usb.list(devices);
  for (std::size_t i = 0; i < all && i < devices.size(); ++i) {
    const char* why_not = "";
    const UsbCameraDriver* driver = driver_of(devices[i], why_not);
    if (driver == nullptr && why_not[0] == '\0') continue;
    if (found++ >= out.size()) continue;
    UsbSighting& sighting = out[found - 1];
    sighting = {};
    sighting.info.device = devices[i];
    if (driver == nullptr) {
      sighting.status = {StatusCode::kUnsupportedDevice, why_not};
      continue;
    }
    sighting.status = open_camera(usb, devices[i], *driver, sighting.info);
    sighting.has_slow_link = is_slow_link(devices[i]);
    usb.close_device();
  }
  return {};
}

}  // namespace egofocus
