// Camera chains as Kalibr writes them (camchain.yaml, camchain-imucam.yaml), and the MVSEC files that follow
// them. Format: Kalibr's wiki, "yaml formats".
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "egofocus/config.hpp"
#include "recording/rigid_transform.hpp"
#include "recording/yaml_file.hpp"

namespace egofocus::recording {

struct KalibrCamera {
  CameraModel model;
  std::optional<RigidTransform> camera_from_imu;
  std::optional<RigidTransform> camera_from_previous;  ///< T_cn_cnm1: from the camera before in the chain
};

/// cam0, cam1, ... as long as there are some. Throws Error: kFile, kBadFile (missing keys, no rigid
/// transforms), kConfiguration (a model other than pinhole with radtan, equidistant or none).
[[nodiscard]] std::vector<KalibrCamera> read_kalibr(const std::filesystem::path& path);

/// Of "radtan", "plumb_bob", "equidistant", "equi", "none" and up to five coefficients. Throws as above.
void set_distortion(CameraModel& model, const YamlFile& yaml, const std::string& model_key,
                    const std::string& coefficients_key);

/// The motion settings for an IMU rigidly fixed to the camera: the IMU's frame is the body.
void set_body(MotionConfig& motion, const RigidTransform& camera_from_imu);

}  // namespace egofocus::recording
