// An MVSEC sequence as the set's own writer lays it out: data, ground truth, camera chain. A slanted
// plane fills the view, so that depth is known on every ray.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "recording/converted.hpp"
#include "recording/hdf5_writer.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"

namespace egofocus::test {

inline constexpr int kWidth = 346;
inline constexpr int kHeight = 260;
inline constexpr double kFx = 226.4;
inline constexpr double kFy = 226.1;
inline constexpr double kCx = 173.6;
inline constexpr double kCy = 133.7;
inline constexpr double kK[4] = {-0.048, 0.011, -0.055, 0.036};
inline constexpr std::int64_t kEpochUs = 1'506'117'934'000'000;
inline constexpr double kEpoch = 1506117934.0;

inline constexpr const char* kCamchain = R"(T_cam0_lidar:
- [1.0, 0.0, 0.0, 0.0]
cam0:
  T_cam_imu:
  - [0.0, -1.0, 0.0, 0.01]
  - [1.0, 0.0, 0.0, 0.02]
  - [0.0, 0.0, 1.0, 0.03]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.048, 0.011, -0.055, 0.036]
  distortion_model: equidistant
  intrinsics: [226.4, 226.1, 173.6, 133.7]
  resolution: [346, 260]
  rostopic: /davis/left/image_raw
cam1:
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.1]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.048, 0.011, -0.055, 0.036]
  distortion_model: equidistant
  intrinsics: [225.0, 225.0, 170.0, 130.0]
  resolution: [346, 260]
)";

/// A slanted plane 0.6 x + 0.3 y + z = 4 in the camera frame: its depth along the ray (x, y, 1).
inline double plane_depth(double x, double y) {
  return 4.0 / (1.0 + 0.6 * x + 0.3 * y);
}

/// What the lidar's depth looks like on the distorted pixels: the ray by bisection of the angle.
inline std::vector<float> distorted_plane() {
  std::vector<float> picture;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const double u = (column - kCx) / kFx;
      const double v = (row - kCy) / kFy;
      const double radius = std::hypot(u, v);
      double low = 0;
      double high = 1.3;
      for (int i = 0; i < 50; ++i) {
        const double t = 0.5 * (low + high);
        const double t2 = t * t;
        (t * (1 + t2 * (kK[0] + t2 * (kK[1] + t2 * (kK[2] + t2 * kK[3])))) < radius ? low : high) = t;
      }
      const double scale = radius < 1e-9 ? 1.0 : std::tan(low) / radius;
      picture.push_back(static_cast<float>(plane_depth(u * scale, v * scale)));
    }
  }
  return picture;
}

struct MvsecSet : TemporaryFolder {
  std::vector<Event> left = some_events(150000, kWidth, kHeight, kEpochUs + 250000);
  std::filesystem::path data = *this / "flying_data.hdf5";
  std::filesystem::path truth = *this / "flying_gt.hdf5";

  MvsecSet() {
    recording::write_text_file(*this / "camchain-imucam-flying.yaml", kCamchain);
    write_data();
    write_truth();
  }

  static std::vector<double> rows_of(const std::vector<Event>& events) {
    std::vector<double> rows;
    for (const Event& event : events) {
      rows.insert(rows.end(), {static_cast<double>(event.x), static_cast<double>(event.y),
                               static_cast<double>(event.t_us) * 1e-6, event.polarity ? 1.0 : -1.0});
    }
    return rows;
  }

  void write_data() const {
    Hdf5Writer file(data);
    file.write("/davis/left/events", H5T_IEEE_F64LE, {left.size(), 4}, rows_of(left));
    file.write("/davis/right/events", H5T_IEEE_F64LE, {900, 4}, rows_of({left.begin(), left.begin() + 900}));
    // The second sample has no number in it, and the third comes again.
    file.write("/davis/left/imu", H5T_IEEE_F64LE, {4, 6},
               std::vector<double>{0.5, -1.5, 9.75, 0.125, 0.25, -0.5, NAN, 0, 0, 0, 0, 0,
                                   1,   2,    3,    4,     5,    6,    1,   2, 3, 4, 5, 6});
    file.write("/davis/left/imu_ts", H5T_IEEE_F64LE, {4},
               std::vector<double>{kEpoch + 0.3, kEpoch + 0.4, kEpoch + 0.5, kEpoch + 0.5});
    file.write("/davis/left/image_raw", H5T_IEEE_F32LE, {1}, std::vector<float>{0});
  }

  void write_truth(H5Z_filter_t filter = 0) const {
    Hdf5Writer file(truth);
    const double c = std::cos(0.5);
    const double s = std::sin(0.5);
    std::vector<double> poses;
    for (int i = 0; i < 40; ++i) {
      poses.insert(poses.end(), {c, -s, 0, 0.1 * i, s, c, 0, -1, 0, 0, 1, 2, 0, 0, 0, 1});
    }
    std::vector<double> times;
    for (int i = 0; i < 40; ++i) times.push_back(kEpoch + 0.05 * i);
    file.write("/davis/left/odometry", H5T_IEEE_F64LE, {40, 4, 4}, poses);
    file.write("/davis/left/odometry_ts", H5T_IEEE_F64LE, {40}, times);
    std::vector<float> depth = distorted_plane();
    for (int row = 128; row < 140; ++row) {
      for (int column = 168; column < 180; ++column)
        depth[static_cast<std::size_t>(row * kWidth + column)] = NAN;
    }
    std::vector<float> both = depth;
    both.insert(both.end(), depth.begin(), depth.end());
    both[static_cast<std::size_t>(134 * kWidth + 200)] = 500.0f;
    for (const std::string side : {"left", "right"}) {
      file.write("/davis/" + side + "/depth_image_raw", H5T_IEEE_F32LE, {2, kHeight, kWidth}, both, filter);
      file.write("/davis/" + side + "/depth_image_raw_ts", H5T_IEEE_F64LE, {2},
                 std::vector<double>{kEpoch + 0.45, kEpoch + 0.65});
    }
    file.write("/davis/left/depth_image_rect", H5T_IEEE_F32LE, {1}, std::vector<float>{0});
  }
};

}  // namespace egofocus::test
