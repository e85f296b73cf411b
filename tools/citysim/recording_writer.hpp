// A world, filmed into a recording folder: whole or not at all, and resumed where it was interrupted.
//
//   events.raw, camera.toml, can.log, robot.dbc, poses.txt, depth/*.png     docs/formats.md
//   velocities.txt          t vx vy vz wx wy wz of the camera in its own frame, exact
//   pictures/grey/*.png     8 bit, on the working grid, at the depth's times; pictures/rgb/*.png likewise
//   citysim.json            how it was made: arguments, every parameter drawn, counts
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "citysim/world.hpp"

namespace egofocus::citysim {

struct RecordingOptions {
  Family family{};
  int frames = 1500;  ///< depth pictures, at 20 Hz
  std::uint64_t seed = 1;
  int width_px = 346;
  int height_px = 260;
  bool clean_sensor = false;
  bool pictures = true;
  int threads = 2;
  std::function<void(int, int)> progress;  ///< frames done, frames in all
};

struct RecordingReport {
  std::uint64_t events = 0;
  std::uint64_t views = 0;
  double wide_steps_share = 0;  ///< views with more than 1 px of motion since the last for over 1 % of pixels
  double seconds = 0;           ///< of the recording
  int resumed_at = 0;           ///< frame; 0: from the start
};

/// The first depth picture is at this time, the next ones each kFramePeriodUs.
inline constexpr std::int64_t kFirstFrameUs = 300000;
inline constexpr std::int64_t kFramePeriodUs = 50000;

/// Writes into `<out>.partial`, which becomes `out` at the end. A partial folder of the same arguments is
/// gone on with, to the same bytes. Throws recording::Error: kUsage when `out` is taken, or its partial
/// folder belongs to other arguments; kFile when the disk refuses.
RecordingReport write_recording(const RecordingOptions& options, const std::filesystem::path& out);

}  // namespace egofocus::citysim
