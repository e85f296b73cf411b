#include "recording/convert_ecd.hpp"

#include <algorithm>

#include "core/decimal.hpp"
#include "hal/text_words.hpp"
#include "recording/camera_toml.hpp"
#include "recording/error.hpp"
#include "recording/folder.hpp"
#include "recording/mapped_file.hpp"
#include "recording/pose_file.hpp"
#include "recording/raw_file.hpp"
#include "recording/text_events.hpp"
#include "recording/text_file.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kHourUs = 3600LL * 1000000;
constexpr std::uint16_t kMaxSidePx = 2048;  // EVT3 addresses have 11 bits

struct Calibration {
  double fx, fy, cx, cy;
  double coefficients[5];
};

Calibration read_calibration(const fs::path& path) {
  std::string text = read_text_file(path);
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::string_view rest = text;
  double values[9] = {};
  std::size_t count = 0;
  for (std::string_view word = take_word(rest); !word.empty(); word = take_word(rest), ++count) {
    Decimal number;
    if (count == 9 || scan_decimal(word, number) != word.size() || !to_double(number, values[count])) {
      throw Error(ExitCode::kBadFile, path.string(),
                  "must hold the numbers `fx fy cx cy k1 k2 p1 p2 k3` and nothing else.");
    }
  }
  if (count < 4)
    throw Error(ExitCode::kBadFile, path.string(), "ends before the fourth of `fx fy cx cy k1 k2 p1 p2 k3`.");
  return {
      values[0], values[1], values[2], values[3], {values[4], values[5], values[6], values[7], values[8]}};
}

/// The centre of a picture lies in the middle half of its sensor.
bool fits(const Calibration& calibration, SensorSize size) {
  const auto central = [](double at, double side) { return at > 0.25 * side && at < 0.75 * side; };
  return central(calibration.cx, size.width_px) && central(calibration.cy, size.height_px);
}

SensorSize choose_size(const EcdOptions& options, const Calibration& calibration,
                       const std::vector<Event>& events) {
  if (options.size) {
    if (options.size->width_px > kMaxSidePx || options.size->height_px > kMaxSidePx) {
      throw Error(ExitCode::kUsage, "--size", "at most 2048x2048 px fit into events.raw.");
    }
    if (!fits(calibration, *options.size)) {
      throw Error(ExitCode::kConfiguration, "calib.txt",
                  "its cx, cy do not lie near the middle of --size. Is this the right sensor?");
    }
    return *options.size;
  }
  int width = 0;
  int height = 0;
  for (const Event& event : events) {
    width = std::max<int>(width, event.x + 1);
    height = std::max<int>(height, event.y + 1);
  }
  static constexpr SensorSize kKnown[] = {{240, 180}, {320, 240}, {346, 260}, {640, 480}, {1280, 720}};
  for (const SensorSize& size : kKnown) {
    if (width <= size.width_px && height <= size.height_px && fits(calibration, size)) return size;
  }
  throw Error(ExitCode::kConfiguration, "events and calib.txt",
              "fit no known sensor (events reach " + std::to_string(width) + "x" + std::to_string(height) +
                  "). Give --size WxH.");
}

fs::path find_events(const fs::path& input) {
  for (const char* name : {"events.txt", "events_chunk.txt"}) {
    if (fs::exists(input / name)) return input / name;
  }
  throw Error(ExitCode::kFile, input.string(),
              "holds neither events.txt nor events_chunk.txt. Is this an ECD folder?");
}

/// Moves the origin, drops what lies before it or outside the sensor, and counts both.
void move_events(std::vector<Event>& events, EcdReport& report) {
  const auto dropped = [&report](Event& event) {
    event.t_us -= report.t0_us;
    if (event.t_us < 0) {
      ++report.before_t0;
      return true;
    }
    const bool outside = event.x >= report.size.width_px || event.y >= report.size.height_px;
    report.out_of_range += outside ? 1 : 0;
    return outside;
  };
  std::vector<Event> kept;
  for (Event event : events) {
    if (!dropped(event)) kept.push_back(event);
  }
  events.swap(kept);
}

CameraFile camera_of(const Calibration& calibration, SensorSize size, double z_near_m) {
  CameraFile file;
  Config& config = file.config;
  config.camera.intrinsics = {size.width_px,  size.height_px, calibration.fx,
                              calibration.fy, calibration.cx, calibration.cy};
  for (std::size_t i = 0; i < 5; ++i) {
    config.camera.coefficients[i] = calibration.coefficients[i];
    if (calibration.coefficients[i] != 0) config.camera.distortion = Distortion::kPlumbBob;
  }
  config.grid = config.camera.intrinsics;
  config.ladder.z_near_m = z_near_m;
  config.motion.source = MotionSource::kPoses;
  return file;
}

}  // namespace

EcdReport convert_ecd(const fs::path& input, const fs::path& output, const EcdOptions& options) {
  if (is_recording(output)) {
    throw Error(ExitCode::kUsage, output.string(),
                "already holds a recording. Choose another folder, or remove it first.");
  }
  const fs::path events_path = find_events(input);
  const Calibration calibration = read_calibration(input / "calib.txt");
  const fs::path poses_path = input / "groundtruth.txt";
  if (!fs::exists(poses_path)) {
    throw Error(ExitCode::kMotion, poses_path.string(),
                "is missing, so the recording would have no motion. Without poses there is no depth.");
  }
  std::vector<PoseSample> poses = parse_poses(MappedFile(poses_path).text(), poses_path.string());
  TextEvents text = parse_text_events(MappedFile(events_path).text(), options.progress);
  if (text.events.empty()) {
    throw Error(ExitCode::kNoEvents, events_path.string(),
                "holds no event `t x y p` (" + std::to_string(text.malformed) +
                    " malformed lines). Is it the right file?");
  }

  EcdReport report;
  report.malformed = text.malformed;
  report.out_of_order = text.out_of_order;
  report.size = choose_size(options, calibration, text.events);
  const std::int64_t first_us = text.events.front().t_us;
  report.t0_us = options.t0_us.value_or(first_us > kHourUs ? first_us / 1000000 * 1000000 : 0);
  move_events(text.events, report);
  if (text.events.empty()) {
    throw Error(ExitCode::kNoEvents, events_path.string(), "has no event inside the sensor after --t0.");
  }
  for (PoseSample& pose : poses) pose.t_us -= report.t0_us;
  report.events = text.events.size();
  report.first_us = text.events.front().t_us;
  report.last_us = text.events.back().t_us;
  report.poses = poses.size();
  for (const Event& event : text.events) {
    if (poses.empty() || event.t_us < poses.front().t_us) ++report.events_before_poses;
    if (!poses.empty() && event.t_us > poses.back().t_us) ++report.events_after_poses;
  }
  for (const char* name : {"imu.txt", "images.txt"}) {
    if (fs::exists(input / name)) report.left_out.emplace_back(name);
  }

  std::error_code failure;
  fs::create_directories(output, failure);
  write_camera_toml(output / "camera.toml", camera_of(calibration, report.size, options.z_near_m));
  write_text_file(output / "poses.txt", poses_text(poses));
  write_raw_file(output / "events.raw", text.events, report.size);
  return report;
}

}  // namespace egofocus::recording
