#include "describe_cameras.hpp"

#include <cstdio>
#include <string>
#include <vector>

namespace egofocus::app {
namespace {

using recording::ExitCode;
using recording::Json;

const char* state_of(const UsbSighting& camera) {
  switch (camera.status.code()) {
    case StatusCode::kOk:
      return "ready";
    case StatusCode::kNoPermission:
      return "no permission";
    case StatusCode::kDeviceBusy:
      return "claimed by another process";
    case StatusCode::kUnknownFirmware:
      return "unknown firmware";
    case StatusCode::kUnsupportedDevice:
      return "not supported";
    default:
      return "does not answer";
  }
}

const char* speed_of(UsbSpeed speed) {
  constexpr const char* kNames[] = {"unknown", "1.5 Mbit/s", "12 Mbit/s", "480 Mbit/s (USB 2)",
                                    "5 Gbit/s or more"};
  return kNames[static_cast<std::size_t>(speed)];
}

std::string usb_id(const UsbDevice& device) {
  char text[16];
  std::snprintf(text, sizeof text, "%04x:%04x", device.vendor, device.product);
  return text;
}

std::string place(const UsbDevice& device) {
  char text[32];
  std::snprintf(text, sizeof text, "bus %03d device %03d", int{device.bus}, int{device.address});
  return text;
}

std::string line_of(const Status& status) {
  char text[400];
  status.describe(text);
  return text;
}

Json describe(const UsbSighting& camera) {
  const UsbCameraInfo& info = camera.info;
  Json facts;
  facts.add("camera", info.name[0] != '\0' ? info.name : "unknown")
      .add("state", state_of(camera))
      .add("usb_id", usb_id(info.device))
      .add("place", place(info.device))
      .add("link", speed_of(info.device.speed));
  if (info.serial[0] != '\0') facts.add("serial", info.serial);
  if (info.logic != 0) facts.add("logic_version", info.logic).add("firmware", info.firmware);
  if (info.size.width_px != 0)
    facts.add("width_px", info.size.width_px).add("height_px", info.size.height_px);
  if (!camera.status.ok()) facts.add("problem", line_of(camera.status));
  if (camera.has_slow_link)
    facts.add(
        "warning",
        "USB 2 link: the camera or the system will drop events in busy scenes. Use a USB 3 port and cable.");
  return facts;
}

}  // namespace

Json describe_cameras(std::span<const UsbSighting> cameras) {
  std::vector<Json> all;
  for (const UsbSighting& camera : cameras) all.push_back(describe(camera));
  Json facts;
  return facts.add("cameras", all);
}

ExitCode verdict(std::span<const UsbSighting> cameras) {
  for (const UsbSighting& camera : cameras) {
    if (camera.status.ok()) return ExitCode::kOk;
  }
  return cameras.empty() ? ExitCode::kNoDevice : ExitCode::kDevice;
}

}  // namespace egofocus::app
