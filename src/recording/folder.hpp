// A recording on disk: one folder of files that other tools read, too.
//
//   events.raw    Prophesee RAW (EVT2, EVT2.1 or EVT3)
//   camera.toml   camera, depth and motion settings (camera_toml.hpp)
//   poses.txt     motion source "poses"
//   can.log       candump -L; with the DBC that camera.toml names: motion source "odometry"
//   depth/*.png   truth where it is known: 16-bit grey, named by its time, <t_us, 12 digits>.png
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "egofocus/types.hpp"
#include "recording/camera_toml.hpp"
#include "recording/mapped_file.hpp"
#include "recording/picture.hpp"

namespace egofocus::recording {

/// Truth of one instant, not yet read.
struct DepthTruth {
  std::int64_t t_us = 0;
  std::filesystem::path path;
};

/// Everything but the depth pictures, checked and in memory (mapped). Spans into it live as long as it does.
struct Folder {
  std::filesystem::path path;
  CameraFile camera;
  MappedFile events;              ///< events.raw
  MappedFile can;                 ///< can.log; empty when there is none
  std::string dbc;                ///< text of the DBC; empty when there is none
  MappedFile pose_file;           ///< poses.txt; empty when there is none
  std::vector<PoseSample> poses;  ///< the same, parsed
  std::vector<DepthTruth> truth;  ///< ascending in time, then by name

  /// The truth at exactly this time, if there is one.
  [[nodiscard]] const DepthTruth* truth_at(std::int64_t t_us) const;
};

/// Opens and checks. `source` overrides [motion] source. Throws Error: kFile (missing), kBadFile,
/// kConfiguration, and kMotion when the wanted motion is not there or has an interior gap.
[[nodiscard]] Folder open_folder(const std::filesystem::path& path, std::optional<MotionSource> source = {});

/// The same without motion: camera, events and truth alone. Throws Error: kFile, kBadFile, kConfiguration,
/// kNoEvents.
[[nodiscard]] Folder open_events_and_truth(const std::filesystem::path& path);

/// Is this a folder with an events.raw in it?
[[nodiscard]] bool is_recording(const std::filesystem::path& path);

/// "depth/000000123456.png"
[[nodiscard]] std::string depth_name(std::int64_t t_us);

/// In a depth picture: at or beyond what its scale can tell, sky included.
inline constexpr std::uint16_t kFarthestDepthUnit = 65535;

/// Depth in metres, row-major; 0 where unknown, infinity where farther than the scale can tell. The picture's
/// size must be the grid's. Throws Error.
[[nodiscard]] Picture<float> read_depth(const DepthTruth& truth, const CameraFile& camera);

}  // namespace egofocus::recording
