#include "recording/folder.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

#include "recording/error.hpp"
#include "recording/png_io.hpp"
#include "recording/pose_file.hpp"
#include "recording/text_file.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kFarthestUs = std::int64_t{1} << 60;  // differences of times never overflow

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::vector<DepthTruth> list_truth(const fs::path& folder) {
  std::vector<DepthTruth> truth;
  std::error_code failure;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failure)) {
    if (entry.path().extension() != ".png") continue;
    const std::string stem = entry.path().stem().string();
    DepthTruth item{0, entry.path()};
    const char* const end = stem.data() + stem.size();
    if (const auto [stop, error] = std::from_chars(stem.data(), end, item.t_us);
        stop != end || error != std::errc() || item.t_us < -kFarthestUs || item.t_us > kFarthestUs) {
      throw Error(ExitCode::kBadFile, entry.path().string(),
                  "the name of a depth picture is its time in microseconds, such as 000000123456.png.");
    }
    truth.push_back(std::move(item));
  }
  std::sort(truth.begin(), truth.end(), [](const DepthTruth& a, const DepthTruth& b) {
    return a.t_us != b.t_us ? a.t_us < b.t_us : a.path < b.path;
  });
  return truth;
}

void load_can(Folder& folder) {
  const fs::path log = folder.path / "can.log";
  if (is_there(log)) folder.can = MappedFile(log);
  if (!folder.camera.can.dbc.empty()) folder.dbc = read_text_file(folder.path / folder.camera.can.dbc);
}

void load_poses(Folder& folder) {
  const fs::path path = folder.path / "poses.txt";
  if (!is_there(path)) return;
  folder.pose_file = MappedFile(path);
  folder.poses = parse_poses(folder.pose_file.text(), path.string());
}

void check_motion(const Folder& folder) {
  const std::string where = folder.path.string();
  const MotionConfig& motion = folder.camera.config.motion;
  if (motion.source == MotionSource::kPoses) {
    if (folder.poses.size() < 2) {
      throw Error(ExitCode::kMotion, where,
                  "no motion: camera.toml asks for poses, and poses.txt is missing or holds fewer than two. "
                  "Add it, or set "
                  "[motion] source = \"odometry\" and give can.log.");
    }
    check_pose_gaps(folder.poses, motion.max_pose_gap_us, (folder.path / "poses.txt").string());
    return;
  }
  if (folder.camera.can.motion.signal_count == 0) {
    throw Error(ExitCode::kConfiguration, (folder.path / "camera.toml").string(),
                "the motion source is odometry, and [can] names no signals. Add [[can.signals]], or set "
                "[motion] source "
                "= \"poses\".");
  }
  if (folder.can.bytes().empty()) {
    throw Error(ExitCode::kMotion, where,
                "no motion: camera.toml asks for odometry, and can.log is missing or empty. Add it, or set "
                "[motion] source "
                "= \"poses\" and give poses.txt.");
  }
}

}  // namespace

const DepthTruth* Folder::truth_at(std::int64_t t_us) const {
  const auto found = std::lower_bound(truth.begin(), truth.end(), t_us,
                                      [](const DepthTruth& item, std::int64_t t) { return item.t_us < t; });
  return found != truth.end() && found->t_us == t_us ? &*found : nullptr;
}

bool is_recording(const fs::path& path) {
  return is_there(path / "events.raw");
}

std::string depth_name(std::int64_t t_us) {
  const std::string digits = std::to_string(t_us);
  return "depth/" + std::string(digits.size() < 12 ? 12 - digits.size() : 0, '0') + digits + ".png";
}

Folder open_events_and_truth(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    throw Error(ExitCode::kFile, path.string(),
                "is no recording folder. `egofocus convert` makes one from text sets; docs/formats.md says "
                "what is in it.");
  }
  Folder folder;
  folder.path = path;
  folder.camera = read_camera_toml(path / "camera.toml");
  folder.events = MappedFile(path / "events.raw");
  if (folder.events.bytes().empty()) {
    throw Error(ExitCode::kNoEvents, (path / "events.raw").string(),
                "is empty. Record again, or convert the text set again.");
  }
  folder.truth = list_truth(path / "depth");
  return folder;
}

Folder open_folder(const fs::path& path, std::optional<MotionSource> source) {
  Folder folder = open_events_and_truth(path);
  if (source) folder.camera.config.motion.source = *source;
  load_can(folder);
  load_poses(folder);
  check_motion(folder);
  return folder;
}

Picture<float> read_depth(const DepthTruth& truth, const CameraFile& camera) {
  const Intrinsics& grid =
      camera.config.grid.width_px != 0 ? camera.config.grid : camera.config.camera.intrinsics;
  const Grey16Picture raw = read_grey16_png(truth.path);
  if (raw.width_px != grid.width_px || raw.height_px != grid.height_px) {
    throw Error(ExitCode::kBadFile, truth.path.string(),
                "is " + std::to_string(raw.width_px) + "x" + std::to_string(raw.height_px) +
                    " px; the working grid of camera.toml is " + std::to_string(grid.width_px) + "x" +
                    std::to_string(grid.height_px) + " px. They must agree.");
  }
  Picture<float> depth(raw.width_px, raw.height_px);
  for (std::size_t i = 0; i < raw.pixels.size(); ++i) {
    depth.pixels[i] = raw.pixels[i] == kFarthestDepthUnit
                          ? std::numeric_limits<float>::infinity()
                          : static_cast<float>(raw.pixels[i] * camera.depth_scale_m);
  }
  return depth;
}

}  // namespace egofocus::recording
