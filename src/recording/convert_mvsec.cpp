#include "recording/convert_mvsec.hpp"

#include "recording/depth_truth.hpp"
#include "recording/error.hpp"
#include "recording/hdf5_columns.hpp"
#include "recording/kalibr.hpp"
#include "recording/recording_builder.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

constexpr double kDepthScaleM = 0.002;  // 131 m in 16 bits: the lidar's range
constexpr std::string_view kDataSuffix = "_data.hdf5";

/// The one file of the folder that `is_it` accepts; an empty path if there is none.
template <typename Predicate>
fs::path only_file(const fs::path& folder, const char* what, const Predicate& is_it) {
  fs::path found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!is_it(entry.path().filename().string())) continue;
    if (!found.empty()) {
      throw Error(ExitCode::kUsage, folder.string(),
                  std::string("holds several files ") + what + ". Name the one that is meant.");
    }
    found = entry.path();
  }
  return found;
}

fs::path find_data(const fs::path& input) {
  if (!fs::is_directory(input)) return input;
  const fs::path found =
      only_file(input, "*_data.hdf5", [](const std::string& name) { return name.ends_with(kDataSuffix); });
  if (found.empty())
    throw Error(ExitCode::kFile, input.string(), "holds no *_data.hdf5. Is this an MVSEC folder?");
  return found;
}

fs::path find_ground_truth(const fs::path& data) {
  std::string name = data.filename().string();
  if (!name.ends_with(kDataSuffix)) return {};
  name.replace(name.size() - kDataSuffix.size(), std::string::npos, "_gt.hdf5");
  const fs::path path = data.parent_path() / name;
  return fs::exists(path) ? path : fs::path();
}

fs::path find_calibration(const fs::path& data, const ConvertOptions& options) {
  if (!options.kalibr.empty()) return options.kalibr;
  const fs::path folder = data.has_parent_path() ? data.parent_path() : ".";
  const fs::path found = only_file(folder, "camchain*.yaml", [](const std::string& name) {
    return name.starts_with("camchain") && name.ends_with(".yaml");
  });
  if (found.empty()) {
    throw Error(ExitCode::kConfiguration, folder.string(),
                "holds no camchain*.yaml. Give the calibration of the sequence with --kalibr FILE.");
  }
  return found;
}

void add_events(const Hdf5File& file, const std::string& name, const ConvertOptions& options,
                RecordingBuilder& builder) {
  const Hdf5Dataset set = file.dataset(name, 2, Hdf5Type::kFloat);
  if (set.row_values() != 4)
    throw Error(ExitCode::kBadFile, set.where(), "must have the four columns x y t p.");
  std::vector<double> rows(4 * kBlockRows);
  std::vector<Event> events;
  for_blocks(set.rows(), kBlockRows, [&](std::uint64_t first, std::size_t count) {
    set.read(first, count, rows);
    events.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const double x = rows[4 * i];
      const double y = rows[4 * i + 1];
      const double p = rows[4 * i + 3];
      Event event;
      event.t_us = x == x && y == y && p == p ? microseconds_of(rows[4 * i + 2]) : kNoTimeUs;
      // Beyond every sensor: the builder counts it as out of range.
      event.x = x > -0.5 && x < 65535 ? static_cast<std::uint16_t>(x + 0.5) : 65535;
      event.y = y > -0.5 && y < 65535 ? static_cast<std::uint16_t>(y + 0.5) : 65535;
      event.polarity = p > 0 ? 1 : 0;
      events.push_back(event);
    }
    builder.add_events(events);
    if (options.progress)
      options.progress(static_cast<std::size_t>(first + count), static_cast<std::size_t>(set.rows()));
  });
}

void add_imu(const Hdf5File& file, const std::string& side, RecordingBuilder& builder) {
  const Hdf5Dataset set = file.dataset(side + "/imu", 2, Hdf5Type::kFloat);
  if (set.row_values() != 6)
    throw Error(ExitCode::kBadFile, set.where(), "must have six columns: accelerometer and gyro.");
  const std::vector<std::int64_t> times = read_times(file, side + "/imu_ts");
  require_pairs(set, times.size());
  std::vector<double> rows(6 * kBlockRows);
  for_blocks(set.rows(), kBlockRows, [&](std::uint64_t first, std::size_t count) {
    set.read(first, count, rows);
    for (std::size_t i = 0; i < count; ++i) {
      ImuReading reading;
      reading.t_us = times[static_cast<std::size_t>(first) + i];
      for (std::size_t k = 0; k < 3; ++k) {
        reading.accel[k] = static_cast<float>(rows[6 * i + k]);
        reading.gyro[k] = static_cast<float>(rows[6 * i + 3 + k]);
      }
      builder.add_imu(reading);
    }
  });
}

/// The left camera's odometry, carried over to the chosen camera.
void add_poses(const Hdf5File& file, const RigidTransform& left_from_camera, RecordingBuilder& builder) {
  const Hdf5Dataset set = file.dataset("/davis/left/odometry", 3, Hdf5Type::kFloat);
  const std::vector<std::int64_t> times = read_times(file, "/davis/left/odometry_ts");
  if (set.row_values() != 16) throw Error(ExitCode::kBadFile, set.where(), "must hold 4x4 matrices.");
  require_pairs(set, times.size());
  std::vector<double> matrix(16);
  for (std::size_t i = 0; i < times.size(); ++i) {
    set.read(i, 1, matrix);
    RigidTransform world_from_left;
    if (!from_matrix(matrix, world_from_left)) {
      ++builder.report.poses_dropped;
      continue;
    }
    const PoseSample pose = pose_of(times[i], world_from_left * left_from_camera);
    builder.add_poses({&pose, 1});
  }
}

void add_depth(const Hdf5File& file, const std::string& side, const ConvertOptions& options,
               RecordingBuilder& builder) {
  const Hdf5Dataset set = file.dataset(side + "/depth_image_raw", 3, Hdf5Type::kFloat);
  const std::vector<std::int64_t> times = read_times(file, side + "/depth_image_raw_ts");
  require_pairs(set, times.size());
  const CameraModel& camera = builder.camera.config.camera;
  const Intrinsics& in = camera.intrinsics;
  if (set.dims()[1] != static_cast<std::uint64_t>(in.height_px) ||
      set.dims()[2] != static_cast<std::uint64_t>(in.width_px)) {
    throw Error(ExitCode::kBadFile, set.where(), "its pictures have another size than the calibration says.");
  }
  const Undistortion undistortion(camera, builder.camera.config.grid);
  Picture<float> raw(in.width_px, in.height_px);
  for (std::size_t i = 0; i < times.size(); ++i) {
    set.read(i, 1, raw.pixels);
    builder.add_depth(times[i], undistortion.depth(raw));
    if (options.progress) options.progress(i + 1, times.size());
  }
}

void name_left_out(const Hdf5File& file, const std::string& side, RecordingBuilder& builder) {
  for (const char* name : {"image_raw", "depth_image_rect", "blended_image_rect", "pose", "flow_dist"}) {
    if (file.has(side + "/" + name)) builder.report.left_out.emplace_back(name);
  }
}

}  // namespace

ConvertReport convert_mvsec(const fs::path& input, const fs::path& output, const ConvertOptions& options) {
  RecordingBuilder builder(output, options);
  const fs::path data_path = find_data(input);
  const Hdf5File data(data_path);
  const fs::path calibration = find_calibration(data_path, options);
  const std::vector<KalibrCamera> cameras = read_kalibr(calibration);
  const std::size_t index = options.camera == CameraSide::kRight ? 1 : 0;
  const std::string side = index == 1 ? "/davis/right" : "/davis/left";
  if (cameras.size() <= index)
    throw Error(ExitCode::kConfiguration, calibration.string(), "has no cam1, the right event camera.");
  const KalibrCamera& camera = cameras[index];
  builder.set_camera(camera.model, calibration.string());
  builder.camera.depth_scale_m = kDepthScaleM;

  const fs::path truth_path = find_ground_truth(data_path);
  std::optional<Hdf5File> truth;
  if (!truth_path.empty()) truth.emplace(truth_path);
  if (!options.poses.empty()) {
    builder.read_poses(options.poses);
  } else if (truth) {
    RigidTransform left_from_camera;
    if (index == 1) {
      if (!camera.camera_from_previous)
        throw Error(ExitCode::kConfiguration, calibration.string(),
                    "has no `cam1.T_cn_cnm1`, which carries the left camera's poses over to the right one.");
      left_from_camera = inverse(*camera.camera_from_previous);
    }
    add_poses(*truth, left_from_camera, builder);
  } else {
    builder.report.remarks.emplace_back(
        "No ground truth beside the data (NAME_gt.hdf5): neither its poses nor its depth.");
  }

  add_events(data, side + "/events", options, builder);
  if (data.has(side + "/imu")) {
    builder.camera.can = imu_can_setup(CanUnit::kSi, CanUnit::kSi);
    if (camera.camera_from_imu) {
      set_body(builder.camera.config.motion, *camera.camera_from_imu);
    } else {
      builder.report.remarks.emplace_back(kUnknownImuAxes);
    }
    add_imu(data, side, builder);
  }
  name_left_out(data, side, builder);
  if (truth) {
    if (truth->has(side + "/depth_image_raw")) add_depth(*truth, side, options, builder);
    name_left_out(*truth, side, builder);
  }
  return builder.finish(data_path.string());
}

}  // namespace egofocus::recording
