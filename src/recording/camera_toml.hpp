// camera.toml: how a recording's camera, motion and depth are to be understood. docs/formats.md has the
// schema.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "egofocus/config.hpp"
#include "hal/can_motion_config.hpp"
#include "recording/usb_schema.hpp"
#include "recording/v4l2_schema.hpp"

namespace egofocus::recording {

/// The CAN part. No signals: the recording has no CAN motion.
struct CanSetup {
  std::string dbc;  ///< file name inside the recording folder
  CanMotionConfig motion;
};

struct CameraFile {
  Config config;
  CanSetup can;
  UsbSetup usb;
  V4l2Setup v4l2;
  double depth_scale_m = 0.001;  ///< metres per unit of depth/*.png
};

/// Unknown sections and keys, wrong types and missing keys of [camera] throw Error (kConfiguration) with the
/// line. Whether the values make sense together is for Engine::required_arena() to say.
[[nodiscard]] CameraFile parse_camera_toml(std::string_view text, const std::string& name);

/// As above, of a file. Throws Error (kFile) when it cannot be read.
[[nodiscard]] CameraFile read_camera_toml(const std::filesystem::path& path);

/// A complete file: each key is written, so that a reader sees what can be set. parse_camera_toml() of it
/// gives the same values, bit for bit.
[[nodiscard]] std::string camera_toml_text(const CameraFile& file);
void write_camera_toml(const std::filesystem::path& path, const CameraFile& file);

}  // namespace egofocus::recording
