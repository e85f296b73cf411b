#include "recording/convert_dsec.hpp"

#include <algorithm>
#include <charconv>

#include "hal/text_words.hpp"
#include "recording/depth_truth.hpp"
#include "recording/error.hpp"
#include "recording/hdf5_columns.hpp"
#include "recording/kalibr.hpp"
#include "recording/png_io.hpp"
#include "recording/recording_builder.hpp"
#include "recording/text_file.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

constexpr double kDepthScaleM = 0.002;  // 131 m in 16 bits

fs::path first_there(const fs::path& folder, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (fs::exists(folder / name)) return folder / name;
  }
  return {};
}

Intrinsics read_intrinsics(const YamlFile& yaml, const std::string& camera) {
  const std::vector<double> k = yaml.numbers("intrinsics." + camera + ".camera_matrix", 4);
  const std::vector<double> size = yaml.numbers("intrinsics." + camera + ".resolution", 2);
  if (!(size[0] >= 1 && size[0] <= 65535 && size[1] >= 1 && size[1] <= 65535))
    throw Error(ExitCode::kBadFile, yaml.name(), "`" + camera + ".resolution` is no size in pixels.");
  return {static_cast<std::int32_t>(size[0]), static_cast<std::int32_t>(size[1]), k[0], k[1], k[2], k[3]};
}

RectifiedView read_view(const YamlFile& yaml) {
  RectifiedView view;
  view.intrinsics = read_intrinsics(yaml, "camRect0");
  const std::vector<double> rotation = yaml.numbers("extrinsics.R_rect0", 9);
  std::copy(rotation.begin(), rotation.end(), view.rectified_from_camera.begin());
  if (!is_rotation(view.rectified_from_camera))
    throw Error(ExitCode::kBadFile, yaml.name(), "`extrinsics.R_rect0` is no rotation.");
  const std::vector<double> q = yaml.numbers("disparity_to_depth.cams_03", 16);
  std::copy(q.begin(), q.end(), view.disparity_to_depth.begin());
  return view;
}

void add_events(const Hdf5File& file, const ConvertOptions& options, RecordingBuilder& builder) {
  const Hdf5Dataset t = file.dataset("/events/t", 1, Hdf5Type::kInteger);
  const Hdf5Dataset x = file.dataset("/events/x", 1, Hdf5Type::kInteger);
  const Hdf5Dataset y = file.dataset("/events/y", 1, Hdf5Type::kInteger);
  const Hdf5Dataset p = file.dataset("/events/p", 1, Hdf5Type::kInteger);
  for (const Hdf5Dataset* column : {&x, &y, &p}) {
    if (column->rows() != t.rows())
      throw Error(ExitCode::kBadFile, column->where(),
                  "has another length than /events/t. Is the file whole?");
  }
  std::int64_t offset_us = 0;
  file.dataset("/t_offset", 0, Hdf5Type::kInteger).read(0, 1, std::span(&offset_us, 1));
  if (offset_us < 0 || offset_us > (std::int64_t{1} << 59))
    throw Error(ExitCode::kBadFile, file.path().string() + ":/t_offset", "is no time in microseconds.");

  std::vector<std::int64_t> columns[4];
  for (auto& column : columns) column.resize(kBlockRows);
  std::vector<Event> events;
  const auto pixel = [](std::int64_t value) {
    return static_cast<std::uint16_t>(value >= 0 && value < 65535 ? value : 65535);
  };
  for_blocks(t.rows(), kBlockRows, [&](std::uint64_t first, std::size_t count) {
    const Hdf5Dataset* const sets[4] = {&t, &x, &y, &p};
    for (std::size_t i = 0; i < 4; ++i) sets[i]->read(first, count, std::span(columns[i]));
    events.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t t_us = columns[0][i];
      const bool possible = t_us >= 0 && t_us < (std::int64_t{1} << 59);
      events.push_back({possible ? t_us + offset_us : kNoTimeUs, pixel(columns[1][i]), pixel(columns[2][i]),
                        static_cast<std::uint8_t>(columns[3][i] > 0 ? 1 : 0)});
    }
    builder.add_events(events);
    if (options.progress)
      options.progress(static_cast<std::size_t>(first + count), static_cast<std::size_t>(t.rows()));
  });
}

std::vector<std::int64_t> read_timestamps(const fs::path& path) {
  std::string text = read_text_file(path);
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::string_view rest = text;
  std::vector<std::int64_t> times;
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest)) {
    std::int64_t t_us = 0;
    const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), t_us);
    if (problem != std::errc() || end != word.data() + word.size()) {
      throw Error(ExitCode::kBadFile, path.string(),
                  "entry " + std::to_string(times.size() + 1) + " is no whole number of microseconds.");
    }
    times.push_back(t_us);
  }
  return times;
}

void add_depth(const fs::path& pictures, const fs::path& times_path, const RectifiedView& view,
               const ConvertOptions& options, RecordingBuilder& builder) {
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(pictures)) {
    if (entry.path().extension() == ".png") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  const std::vector<std::int64_t> times = read_timestamps(times_path);
  // The set itself pairs them by order; one file more or less would shift every depth in time.
  if (times.size() != paths.size()) {
    throw Error(ExitCode::kBadFile, times_path.string(),
                "has " + std::to_string(times.size()) + " times for " + std::to_string(paths.size()) +
                    " pictures in " + pictures.string() + ". Unpack both again.");
  }
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const Grey16Picture disparity = read_grey16_png(paths[i]);
    if (disparity.width_px != view.intrinsics.width_px || disparity.height_px != view.intrinsics.height_px)
      throw Error(ExitCode::kBadFile, paths[i].string(),
                  "has another size than camRect0 in cam_to_cam.yaml.");
    builder.add_depth(times[i], depth_of_disparity(disparity, view, builder.camera.config.grid));
    if (options.progress) options.progress(i + 1, paths.size());
  }
}

}  // namespace

fs::path find_dsec_events(const fs::path& input) {
  return first_there(input, {"events/left/events.h5", "events_left/events.h5"});
}

ConvertReport convert_dsec(const fs::path& input, const fs::path& output, const ConvertOptions& options) {
  if (options.camera == CameraSide::kRight)
    throw Error(ExitCode::kUsage, "--camera", "DSEC's truth is that of the left event camera: left is read.");
  RecordingBuilder builder(output, options);
  const fs::path events_path = find_dsec_events(input);
  if (events_path.empty()) {
    throw Error(ExitCode::kFile, input.string(),
                "holds neither events/left/events.h5 nor events_left/events.h5. Is this a DSEC sequence?");
  }
  const fs::path calibration_path = first_there(input, {"calibration/cam_to_cam.yaml", "cam_to_cam.yaml"});
  if (calibration_path.empty()) {
    throw Error(ExitCode::kConfiguration, input.string(),
                "holds no calibration/cam_to_cam.yaml. Unpack the calibration of the sequence there.");
  }
  const YamlFile yaml(calibration_path);
  CameraModel camera;
  camera.intrinsics = read_intrinsics(yaml, "cam0");
  set_distortion(camera, yaml, "intrinsics.cam0.distortion_model", "intrinsics.cam0.distortion_coeffs");
  builder.set_camera(camera, calibration_path.string());
  builder.camera.depth_scale_m = kDepthScaleM;
  if (!options.poses.empty()) builder.read_poses(options.poses);

  add_events(Hdf5File(events_path), options, builder);
  const fs::path pictures = first_there(input, {"disparity/event", "disparity_event"});
  const fs::path times = first_there(input, {"disparity/timestamps.txt", "disparity_timestamps.txt"});
  if (!pictures.empty() && !times.empty()) {
    add_depth(pictures, times, read_view(yaml), options, builder);
  } else if (!pictures.empty()) {
    throw Error(ExitCode::kFile, pictures.string(),
                "has no timestamps.txt beside it: its times are not known.");
  } else {
    builder.report.remarks.emplace_back(
        "No disparity/event in the sequence: a recording without depth truth.");
  }
  for (const char* name : {"images", "disparity/image", "imu.bag", "lidar_imu.bag"}) {
    if (fs::exists(input / name)) builder.report.left_out.emplace_back(name);
  }
  return builder.finish(events_path.string());
}

}  // namespace egofocus::recording
