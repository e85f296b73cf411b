#include "support/planes_recording.hpp"

#include "recording/pose_file.hpp"

namespace egofocus::sim {

namespace {

void add_signal(CanMotionConfig& config, std::string_view message, std::string_view signal, CanRole role,
                CanUnit unit = CanUnit::kSi) {
  CanSignalRole& entry = config.signals[config.signal_count++];
  message.copy(entry.message, kMaxDbcName);
  signal.copy(entry.signal, kMaxDbcName);
  entry.role = role;
  entry.unit = unit;
}

}  // namespace

recording::CameraFile planes_camera(const PlaneSimulator& simulator) {
  recording::CameraFile file = simulator.camera();
  file.config.window.max_age_us = 200000;  // shorter than a phase of the fixture
  file.can.dbc = "vehicle.dbc";
  CanMotionConfig& can = file.can.motion;
  can.group_window_us = 2000;
  add_signal(can, "IMU_RATE", "GyroX", CanRole::kGyroX, CanUnit::kDegPerSecond);
  add_signal(can, "IMU_RATE", "GyroY", CanRole::kGyroY, CanUnit::kDegPerSecond);
  add_signal(can, "IMU_RATE", "GyroZ", CanRole::kGyroZ, CanUnit::kDegPerSecond);
  add_signal(can, "IMU_FORCE", "AccelX", CanRole::kAccelX);
  add_signal(can, "IMU_FORCE", "AccelY", CanRole::kAccelY);
  add_signal(can, "IMU_FORCE", "AccelZ", CanRole::kAccelZ);
  add_signal(can, "BODY_MOTION", "VelX", CanRole::kVelocityX);
  add_signal(can, "BODY_MOTION", "VelY", CanRole::kVelocityY);
  add_signal(can, "BODY_MOTION", "VelZ", CanRole::kVelocityZ);
  return file;
}

std::map<std::string, std::string> planes_texts(const PlaneSimulator& simulator) {
  return {{"can.log", simulator.can_log()},
          {"vehicle.dbc", vehicle_dbc()},
          {"poses.txt", recording::poses_text(simulator.poses())},
          {"camera.toml", recording::camera_toml_text(planes_camera(simulator))}};
}

std::vector<std::int64_t> planes_ticks(const PlaneSimulator& simulator) {
  std::vector<std::int64_t> ticks;
  constexpr std::int64_t kPeriod = PlaneSimulator::kTickPeriodUs;
  for (std::int64_t t = kPeriod; t <= simulator.trajectory().duration_us(); t += kPeriod) ticks.push_back(t);
  return ticks;
}

}  // namespace egofocus::sim
