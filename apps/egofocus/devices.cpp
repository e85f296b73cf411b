#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "commands.hpp"
#include "describe_cameras.hpp"

namespace egofocus::app {

namespace {

using recording::Error;
using recording::ExitCode;

std::vector<UsbSighting> look_on_usb() {
  const UsbIo* usb = system_usb();
  if (usb == nullptr) {
    throw Error(ExitCode::kNoDevice, "devices",
                "this build has no USB. Install libusb (Debian: libusb-1.0-0-dev) and build again with "
                "EGOFOCUS_USB=ON.");
  }
  std::vector<UsbSighting> cameras(64);
  std::size_t found = 0;
  if (const Status status = survey_usb(*usb, cameras, found); !status.ok()) {
    char text[300];
    status.describe(text);
    throw Error(ExitCode::kDevice, "devices", text);
  }
  cameras.resize(std::min(found, cameras.size()));
  return cameras;
}

std::vector<V4l2Listed> look_on_v4l2() {
  std::vector<V4l2Listed> sensors(16);
  sensors.resize(std::min(list_v4l2_cameras(sensors), sensors.size()));
  return sensors;
}

}  // namespace

void add_devices(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "devices", "list event cameras on USB and event sensors on V4L2, and whether they can be used");
  auto as_json = std::make_shared<bool>(false);
  command->add_flag("--json", *as_json, "one line of JSON");
  command->footer(
      "Exit codes: 0 a camera can be used, 10 there is none (or no USB in this build), 11 none can be used.");
  command->callback([as_json] {
    const std::vector<V4l2Listed> sensors = look_on_v4l2();
    std::vector<UsbSighting> cameras;
    if (system_usb() != nullptr || sensors.empty()) cameras = look_on_usb();
    const recording::Json facts = describe_cameras(cameras, sensors);
    const bool is_empty = cameras.empty() && sensors.empty();
    if (*as_json || !is_empty) std::puts((*as_json ? facts.json() : facts.text()).c_str());
    const ExitCode code = verdict(cameras, sensors);
    if (code == ExitCode::kNoDevice) {
      throw Error(code, "devices",
                  "no event camera on USB or V4L2. Is it plugged in and powered (`lsusb`), and known "
                  "(docs/devices.md)? Are the sensor's kernel modules loaded (docs/v4l2.md)?");
    }
    if (code == ExitCode::kDevice)
      throw Error(code, "devices", "no camera can be used; `problem` above says why and what to do.");
  });
}

}  // namespace egofocus::app
