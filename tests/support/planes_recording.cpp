#include "support/planes_recording.hpp"

#include "recording/pose_file.hpp"
#include "recording/raw_file.hpp"

namespace egofocus::sim {

recording::CameraFile planes_camera(const PlaneSimulator& simulator) {
  recording::CameraFile file = simulator.camera();
  file.can.dbc = "vehicle.dbc";
  file.can.signals = {
      {"IMU_RATE", "GyroX", "gyro_x", "deg/s", 1},     {"IMU_RATE", "GyroY", "gyro_y", "deg/s", 1},
      {"IMU_RATE", "GyroZ", "gyro_z", "deg/s", 1},     {"IMU_FORCE", "AccelX", "accel_x", "m/s^2", 1},
      {"IMU_FORCE", "AccelY", "accel_y", "m/s^2", 1},  {"IMU_FORCE", "AccelZ", "accel_z", "m/s^2", 1},
      {"BODY_MOTION", "VelX", "velocity_x", "m/s", 1}, {"BODY_MOTION", "VelY", "velocity_y", "m/s", 1},
      {"BODY_MOTION", "VelZ", "velocity_z", "m/s", 1}};
  return file;
}

std::map<std::string, std::string> planes_files(PlaneSimulator& simulator) {
  const Intrinsics& camera = simulator.camera().config.camera.intrinsics;
  const SensorSize size{static_cast<std::uint16_t>(camera.width_px),
                        static_cast<std::uint16_t>(camera.height_px)};
  const std::vector<std::byte> raw = recording::raw_file_bytes(simulator.events(), size);
  return {{"events.raw", std::string(reinterpret_cast<const char*>(raw.data()), raw.size())},
          {"can.log", simulator.can_log()},
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
