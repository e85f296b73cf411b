#include <cstdio>
#include <memory>
#include <vector>

#include "commands.hpp"
#include "describe_cameras.hpp"

namespace egofocus::app {

void add_devices(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("devices", "list event cameras on USB and whether they can be used");
  auto as_json = std::make_shared<bool>(false);
  command->add_flag("--json", *as_json, "one line of JSON");
  command->footer(
      "Exit codes: 0 a camera can be used, 10 there is none (or no USB in this build), 11 none can be used.");
  command->callback([as_json] {
    using recording::Error;
    using recording::ExitCode;
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
    cameras.resize(found < cameras.size() ? found : cameras.size());
    const recording::Json facts = describe_cameras(cameras);
    if (*as_json || !cameras.empty()) std::puts((*as_json ? facts.json() : facts.text()).c_str());
    const ExitCode code = verdict(cameras);
    if (code == ExitCode::kNoDevice) {
      throw Error(
          code, "devices",
          "no event camera on USB. Is it plugged in and powered (`lsusb`), and known (docs/devices.md)?");
    }
    if (code == ExitCode::kDevice)
      throw Error(code, "devices", "no camera can be used; `problem` above says why and what to do.");
  });
}

}  // namespace egofocus::app
