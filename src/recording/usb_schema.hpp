// The keys of [usb], each once: see camera_schema.hpp.
#pragma once

#include <string>

#include "hal/usb_camera.hpp"
#include "recording/error.hpp"

namespace egofocus::recording {

/// The section of a live camera on USB. Not given: the file has none.
struct UsbSetup {
  bool is_given = false;
  UsbCameraSettings camera;
};

template <typename Section>
void describe(Section& s, UsbBias& v) {
  s.name("name", v.name);
  s.optional("coarse", v.coarse);
  s.optional("fine", v.fine);
  s.optional("offset", v.offset);
}

template <typename Section, typename AxisNames, typename SensitivityNames>
void describe_usb(Section& s, UsbSetup& v, const AxisNames& axis_names, const SensitivityNames& names) {
  v.is_given = true;
  UsbCameraSettings& camera = v.camera;
  std::string serial = camera.serial;
  s.optional("serial", serial);
  if (serial.size() >= sizeof camera.serial)
    throw Error(ExitCode::kConfiguration, "[usb] `serial`",
                "must have at most " + std::to_string(sizeof camera.serial - 1) + " characters.");
  camera.serial[serial.copy(camera.serial, serial.size())] = '\0';
  s.optional("transfers", camera.transfers);
  s.optional("transfer_bytes", camera.transfer_bytes);
  s.optional("imu", camera.imu);
  s.axes("imu_axes", camera.imu_axes, axis_names);
  s.optional("background_filter", camera.background_filter);
  s.choice("sensitivity", camera.sensitivity, names);
  s.optional("reopen", camera.reopen);
  s.tables("biases", camera.biases, camera.bias_count);
}

}  // namespace egofocus::recording
