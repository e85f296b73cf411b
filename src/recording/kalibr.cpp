#include "recording/kalibr.hpp"

#include <algorithm>
#include <string>

#include "recording/error.hpp"

namespace egofocus::recording {
namespace {

std::optional<RigidTransform> read_transform(const YamlFile& yaml, const std::string& key) {
  if (!yaml.has(key)) return {};
  RigidTransform transform;
  if (!from_matrix(yaml.numbers(key, 16), transform)) {
    throw Error(ExitCode::kBadFile, yaml.name(),
                "`" + key + "` is no rigid transform: a 4x4 matrix with a rotation in it is needed.");
  }
  return transform;
}

KalibrCamera read_camera(const YamlFile& yaml, const std::string& camera) {
  const std::string& model = yaml.text(camera + ".camera_model");
  if (model != "pinhole") {
    throw Error(ExitCode::kConfiguration, yaml.name(),
                "`" + camera + ".camera_model` is " + model + "; only pinhole is known. Calibrate with it.");
  }
  const std::vector<double> k = yaml.numbers(camera + ".intrinsics", 4);
  const std::vector<double> size = yaml.numbers(camera + ".resolution", 2);
  if (!(size[0] >= 1 && size[0] <= 65535 && size[1] >= 1 && size[1] <= 65535)) {
    throw Error(ExitCode::kBadFile, yaml.name(), "`" + camera + ".resolution` is no size in pixels.");
  }
  KalibrCamera result;
  result.model.intrinsics = {
      static_cast<std::int32_t>(size[0]), static_cast<std::int32_t>(size[1]), k[0], k[1], k[2], k[3]};
  set_distortion(result.model, yaml, camera + ".distortion_model", camera + ".distortion_coeffs");
  result.camera_from_imu = read_transform(yaml, camera + ".T_cam_imu");
  result.camera_from_previous = read_transform(yaml, camera + ".T_cn_cnm1");
  return result;
}

}  // namespace

void set_distortion(CameraModel& model, const YamlFile& yaml, const std::string& model_key,
                    const std::string& coefficients_key) {
  const std::string& name = yaml.text(model_key);
  if (name == "none") return;
  const bool fisheye = name == "equidistant" || name == "equi";
  if (!fisheye && name != "radtan" && name != "plumb_bob") {
    throw Error(ExitCode::kConfiguration, yaml.name(),
                "`" + model_key + "` is " + name + "; radtan, equidistant and none are known.");
  }
  const std::vector<double> values = yaml.numbers(coefficients_key, 4, fisheye ? 4 : 5);
  std::copy(values.begin(), values.end(), model.coefficients);
  if (std::any_of(values.begin(), values.end(), [](double v) { return v != 0; }) || fisheye)
    model.distortion = fisheye ? Distortion::kEquidistant : Distortion::kPlumbBob;
}

std::vector<KalibrCamera> read_kalibr(const std::filesystem::path& path) {
  const YamlFile yaml(path);
  std::vector<KalibrCamera> cameras;
  for (std::string name = "cam0"; yaml.has(name + ".camera_model");) {
    cameras.push_back(read_camera(yaml, name));
    name = "cam" + std::to_string(cameras.size());
  }
  if (cameras.empty()) {
    throw Error(ExitCode::kBadFile, path.string(),
                "has no `cam0.camera_model`. Is it a camchain as Kalibr writes it?");
  }
  return cameras;
}

void set_body(MotionConfig& motion, const RigidTransform& camera_from_imu) {
  std::copy(camera_from_imu.rotation.begin(), camera_from_imu.rotation.end(), motion.camera_from_body);
  const RigidTransform imu_from_camera = inverse(camera_from_imu);
  std::copy(imu_from_camera.translation_m.begin(), imu_from_camera.translation_m.end(),
            motion.camera_in_body_m);
}

}  // namespace egofocus::recording
