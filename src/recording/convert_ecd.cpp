#include "recording/convert_ecd.hpp"

#include <algorithm>

#include "core/decimal.hpp"
#include "hal/text_words.hpp"
#include "recording/error.hpp"
#include "recording/mapped_file.hpp"
#include "recording/recording_builder.hpp"
#include "recording/text_events.hpp"
#include "recording/text_file.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

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

SensorSize choose_size(const ConvertOptions& options, const Calibration& calibration,
                       const std::vector<Event>& events) {
  if (options.size) {
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

CameraModel camera_of(const Calibration& calibration, SensorSize size) {
  CameraModel camera;
  camera.intrinsics = {size.width_px,  size.height_px, calibration.fx,
                       calibration.fy, calibration.cx, calibration.cy};
  for (std::size_t i = 0; i < 5; ++i) {
    camera.coefficients[i] = calibration.coefficients[i];
    if (calibration.coefficients[i] != 0) camera.distortion = Distortion::kPlumbBob;
  }
  return camera;
}

}  // namespace

ConvertReport convert_ecd(const fs::path& input, const fs::path& output, const ConvertOptions& options) {
  RecordingBuilder builder(output, options);
  const fs::path events_path = find_events(input);
  const Calibration calibration = read_calibration(input / "calib.txt");
  const fs::path poses_path = options.poses.empty() ? input / "groundtruth.txt" : options.poses;
  if (!fs::exists(poses_path)) {
    throw Error(ExitCode::kMotion, poses_path.string(),
                "is missing, so the recording would have no motion. Without poses there is no depth.");
  }
  builder.read_poses(poses_path);
  const TextEvents text = parse_text_events(MappedFile(events_path).text(), options.progress);
  if (text.events.empty()) {
    throw Error(ExitCode::kNoEvents, events_path.string(),
                "holds no event `t x y p` (" + std::to_string(text.malformed) +
                    " malformed lines). Is it the right file?");
  }
  builder.report.malformed = text.malformed;
  builder.report.out_of_order = text.out_of_order;
  for (const char* name : {"imu.txt", "images.txt"}) {
    if (fs::exists(input / name)) builder.report.left_out.emplace_back(name);
  }
  builder.set_camera(camera_of(calibration, choose_size(options, calibration, text.events)), "--size");
  builder.add_events(text.events);
  return builder.finish(events_path.string());
}

}  // namespace egofocus::recording
