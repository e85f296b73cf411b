// What a configuration comes to: the engine's, with the camera and the model that it names.
#pragma once

#include <optional>
#include <string>

#include "daemon_config.hpp"
#include "egofocus/engine.hpp"
#include "recording/camera_toml.hpp"
#include "recording/model_file.hpp"

namespace egofocus::daemon {

struct Setup {
  /// Reads what is named and asks the engine whether it can be. Opens no device. Throws Error.
  explicit Setup(const DaemonConfig& config);

  /// The grid that depth lies on.
  [[nodiscard]] const Intrinsics& grid() const noexcept;

  DaemonConfig daemon;
  std::string config_text;
  std::filesystem::path camera_file;
  recording::CameraFile camera;  ///< camera.config is the engine's, complete
  std::string dbc;               ///< its text; empty without one
  std::optional<recording::ModelFile> model;
  std::size_t arena_bytes = 0;
};

}  // namespace egofocus::daemon
