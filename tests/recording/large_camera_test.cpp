// A camera of 1280x720 pixels, from files to depth with the network: what it sees is mapped onto the grid
// that camera.toml asks for.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "recording/camera_toml.hpp"
#include "recording/model_file.hpp"
#include "recording/pose_file.hpp"
#include "recording/raw_file.hpp"
#include "recording/replay.hpp"
#include "recording/text_file.hpp"
#include "support/source_dir.hpp"
#include "temporary_folder.hpp"

using namespace egofocus;
using namespace egofocus::recording;

namespace {

constexpr std::int64_t kStart_us = 150'000;  // it stands still until then
constexpr std::int64_t kEnd_us = 452'000;
constexpr double kSpeed_m_s = 0.5;  // to the right
constexpr double kNear_m = 2, kFar_m = 4;

double position_m(std::int64_t t_us) {
  return kSpeed_m_s * 1e-6 * static_cast<double>(std::max<std::int64_t>(t_us - kStart_us, 0));
}

CameraFile camera_file() {
  CameraFile file;
  Config& config = file.config;
  config.camera.intrinsics = {1280, 720, 1060, 1058, 640.5, 357.0};
  config.camera.distortion = Distortion::kPlumbBob;
  config.camera.coefficients[0] = -0.08;
  config.camera.coefficients[1] = 0.01;
  config.grid = {346, 260, 286, 286, 172.5, 129.5};
  config.ladder.z_near_m = 1.5;
  config.window.max_age_us = 200'000;
  config.motion.source = MotionSource::kPoses;
  return file;
}

/// A pixel fires when a dot comes onto it. Dots lie on two walls: left of the world's middle at kNear_m,
/// right of it at kFar_m.
std::vector<Event> events_of_dots(const CameraModel& camera) {
  const Intrinsics& c = camera.intrinsics;
  std::mt19937 random(20);
  const auto between = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  struct Dot {
    std::array<double, 3> at;
    int column = -1;
    int row = -1;
  };
  std::vector<Dot> dots(1600);
  for (Dot& dot : dots) {
    const double z = &dot - dots.data() < 800 ? kNear_m : kFar_m;
    dot.at = {(z == kNear_m ? -1 : 1) * between(0, 0.72 * z), between(-0.36, 0.36) * z, z};
  }
  std::vector<Event> events;
  for (std::int64_t t_us = 0; t_us < kEnd_us; t_us += 200) {
    for (Dot& dot : dots) {
      const double x = (dot.at[0] - position_m(t_us)) / dot.at[2];
      const double y = dot.at[1] / dot.at[2];
      const double r2 = x * x + y * y;
      const double radial = 1 + camera.coefficients[0] * r2 + camera.coefficients[1] * r2 * r2;
      const int column = static_cast<int>(std::lround(c.fx_px * x * radial + c.cx_px));
      const int row = static_cast<int>(std::lround(c.fy_px * y * radial + c.cy_px));
      const bool moved = dot.column >= 0 && (column != dot.column || row != dot.row);
      dot.column = column;
      dot.row = row;
      if (!moved || column < 0 || column >= c.width_px || row < 0 || row >= c.height_px) continue;
      events.push_back({t_us, static_cast<std::uint16_t>(column), static_cast<std::uint16_t>(row),
                        static_cast<std::uint8_t>((column + row) & 1)});
    }
  }
  return events;
}

void write_recording(const std::filesystem::path& folder) {
  const CameraFile file = camera_file();
  write_camera_toml(folder / "camera.toml", file);
  write_raw_file(folder / "events.raw", events_of_dots(file.config.camera), {1280, 720});
  std::vector<PoseSample> poses;
  for (std::int64_t t_us = 0; t_us <= kEnd_us; t_us += 2000) {
    PoseSample pose;
    pose.t_us = t_us;
    pose.position_m[0] = position_m(t_us);
    poses.push_back(pose);
  }
  write_text_file(folder / "poses.txt", poses_text(poses));
}

/// Median of |d - g| / g over the grid's pixels on the left or the right wall, inside the sensor's view.
double median_error(const DepthFrame& frame, bool left) {
  std::vector<float> depth_m(frame.inverse_depth.size());
  REQUIRE(metric_depth(frame, 100, depth_m) == depth_m.size());
  const double truth_m = left ? kNear_m : kFar_m;
  std::vector<double> errors;
  for (std::int32_t v = 0; v < frame.grid.height_px; ++v) {
    for (std::int32_t u = 0; u < frame.grid.width_px; ++u) {
      const double x = (u - frame.grid.cx_px) / frame.grid.fx_px;
      const double y = (v - frame.grid.cy_px) / frame.grid.fy_px;
      if (std::abs(y) > 0.3 || (left ? x > -0.12 || x < -0.55 : x < 0.08 || x > 0.55)) continue;
      const auto at = static_cast<std::size_t>(v * frame.grid.width_px + u);
      errors.push_back(std::abs(static_cast<double>(depth_m[at]) - truth_m) / truth_m);
    }
  }
  REQUIRE(errors.size() > 20'000);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  return errors[errors.size() / 2];
}

}  // namespace

TEST_CASE("1280x720 pixels, seen through the grid of the model's size") {
  const TemporaryFolder folder;
  write_recording(folder.path());
  Folder opened = open_folder(folder.path());
  const ModelFile model(std::filesystem::path(egofocus::test::source_dir()) / "models/base/base.efm");
  opened.camera.config.backend = Backend::kNetwork;
  opened.camera.config.model = model.bytes();
  Replay replay(std::move(opened));
  replay.start(100'000);
  DepthFrame frame;
  REQUIRE(replay.tick(frame));
  CHECK(frame.flags == (kNoParallax | kTooFewEvents));
  CHECK(frame.hypotheses == 0);
  CHECK(std::count(frame.confidence.begin(), frame.confidence.end(), 0) == 346 * 260);

  replay.set_next_tick(450'000);
  REQUIRE(replay.tick(frame));
  CHECK(frame.flags == 0);
  CHECK(frame.grid.width_px == 346);
  CHECK(frame.grid.height_px == 260);
  CHECK(frame.inverse_depth.size() == 346 * 260);
  CHECK(std::count(frame.confidence.begin(), frame.confidence.end(), 0) == 0);
  CHECK(replay.engine().health().events.out_of_range == 0);
  const double near_error = median_error(frame, true);
  const double far_error = median_error(frame, false);
  INFO("median errors: near " << near_error << ", far " << far_error << ", " << frame.events << " events");
  CHECK(near_error < 0.1);
  CHECK(far_error < 0.1);
}
