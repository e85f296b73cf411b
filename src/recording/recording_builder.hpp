// Puts one recording together from streams that share a clock, whatever they were read from. What every
// conversion has in common stands here: the origin of time, the counting, and that nothing half-done is left.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "egofocus/types.hpp"
#include "recording/camera_toml.hpp"
#include "recording/conversion.hpp"
#include "recording/event_file.hpp"
#include "recording/imu_log.hpp"
#include "recording/output_folder.hpp"
#include "recording/picture.hpp"

namespace egofocus::recording {

inline constexpr const char* kUnknownImuAxes =
    "How the IMU lies to the camera is not known (no T_cam_imu): set [can] axes and [motion] "
    "camera_from_body "
    "before the bus is used.";

/// Times are the input's; the builder subtracts t0. Order of calls: camera and poses, events, then the rest.
class RecordingBuilder {
 public:
  /// Refuses an output that holds something. Throws Error (kUsage).
  RecordingBuilder(const std::filesystem::path& output, const ConvertOptions& options);

  CameraFile camera;     ///< complete before the first events; only [can] and [motion] may change later
  ConvertReport report;  ///< `malformed` and the texts are the caller's as well

  /// Sensor and calibration; the grid is the camera's pinhole part. Throws Error (kConfiguration) when
  /// the library cannot use them, (kUsage) when the sensor does not fit into events.raw or is not --size.
  void set_camera(const CameraModel& model, const std::string& where);

  /// Poses of the event camera, in any number of calls.
  void add_poses(std::span<const PoseSample> poses);

  /// A pose file instead of the input's own poses.
  void read_poses(const std::filesystem::path& path);

  /// The first call decides t0 and creates the folder.
  void add_events(std::span<const Event> events);

  void add_imu(const ImuReading& reading);

  /// Metres on the grid; 0 or not finite: unknown. Needs libpng.
  void add_depth(std::int64_t t_us, const Picture<float>& depth_m);

  /// Writes the rest and makes the folder appear. Throws Error: kNoEvents (`where` names the input), kFile.
  ConvertReport finish(const std::string& where);

 private:
  void start(std::int64_t first_event_us);
  bool keep(Event& event);
  void write_motion();

  OutputFolder folder_;
  std::optional<std::int64_t> wanted_t0_us_;
  std::optional<SensorSize> wanted_size_;
  std::optional<EventFile> events_;
  std::optional<ImuLog> imu_;
  std::vector<PoseSample> poses_;  // on the input's clock
  std::vector<Event> kept_;
  std::int64_t last_imu_us_ = -1;
  std::int64_t last_depth_us_ = -1;
};

}  // namespace egofocus::recording
