#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "commands.hpp"
#include "pipeline/working_grid.hpp"
#include "recording/error.hpp"
#include "recording/event_mask.hpp"
#include "recording/event_reader.hpp"
#include "recording/folder.hpp"
#include "recording/json.hpp"
#include "recording/overlay_picture.hpp"
#include "recording/png_io.hpp"
#include "recording/progress.hpp"
#include "recording/replay.hpp"

namespace egofocus::app {
namespace {

namespace fs = std::filesystem;
using recording::Error;
using recording::ExitCode;

struct Arguments {
  std::string recording;
  std::string out;
  std::size_t limit = 20;
  std::int64_t around_us = 2500;
};

/// The frame of a depth picture; empty when there is none.
recording::GreyPicture read_frame(const recording::Folder& folder, const recording::DepthTruth& truth,
                                  const Intrinsics& grid) {
  const fs::path path = folder.path / "pictures/grey" / truth.path.filename();
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return {};
  recording::GreyPicture grey = recording::read_grey_png(path);
  if (grey.width_px != grid.width_px || grey.height_px != grid.height_px) {
    throw Error(ExitCode::kBadFile, path.string(),
                "is not as large as the working grid of camera.toml. Pictures lie on it, as depth does.");
  }
  return grey;
}

void run(const Arguments& arguments) {
  if (!recording::png_available())
    throw Error(ExitCode::kUsage, "overlay", "this build has no libpng. Install libpng-dev and build again.");
  const recording::Folder folder = recording::open_events_and_truth(arguments.recording);
  if (folder.truth.empty())
    throw Error(ExitCode::kFile, (folder.path / "depth").string(),
                "holds no depth pictures to lay events over.");
  const Config& config = folder.camera.config;
  const std::string camera = (folder.path / "camera.toml").string();
  recording::require(check_camera(config), camera);
  const Intrinsics grid = working_grid(config);
  RawHeader header;
  recording::require(parse_raw_header(folder.events.bytes(), header), (folder.path / "events.raw").string(),
                     ExitCode::kBadFile);
  recording::EventReader events(folder.events.bytes(), header);
  const std::vector<std::int32_t> grid_pixel = recording::grid_pixels(config);
  std::error_code failure;
  fs::create_directories(arguments.out, failure);
  if (failure) throw Error(ExitCode::kFile, arguments.out, "cannot be made: " + failure.message());

  const std::size_t count = std::min(arguments.limit, folder.truth.size());
  std::size_t frames = 0;
  std::uint64_t drawn = 0;
  {
    recording::Progress progress("overlay");
    // Evenly over the recording.
    for (std::size_t i = 0; i < count; ++i) {
      const recording::DepthTruth& truth = folder.truth[i * folder.truth.size() / count];
      const std::span<const Event> around =
          events.between(truth.t_us - arguments.around_us - 1, truth.t_us + arguments.around_us);
      const recording::GreyPicture grey = read_frame(folder, truth, grid);
      frames += grey.pixels.empty() ? 0 : 1;
      drawn += around.size();
      recording::write_png(fs::path(arguments.out) / truth.path.filename(),
                           recording::overlay_picture(grid, grey, recording::read_depth(truth, folder.camera),
                                                      around, config.camera.intrinsics.width_px, grid_pixel));
      progress.show(i + 1, count);
    }
  }
  std::puts(recording::Json()
                .add("pictures", arguments.out)
                .add("depth_pictures", count)
                .add("frames", frames)
                .add("events", drawn)
                .text()
                .c_str());
}

}  // namespace

void add_overlay(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "overlay", "pictures of frame, depth and events together: are they in one geometry?");
  auto a = std::make_shared<Arguments>();
  command->add_option("RECORDING", a->recording, "recording folder with depth/*.png")->required();
  command->add_option("--out", a->out, "folder for the pictures, named like the depth")->required();
  command->add_option("--limit", a->limit, "so many, evenly over the recording")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--around-us", a->around_us, "events so long before and after the depth's time")
      ->check(CLI::Range(std::int64_t{0}, std::int64_t{1000000}))
      ->capture_default_str();
  command->footer(
      "The grey ground is pictures/grey/<t_us>.png where there is one, the green lines are isolines of "
      "depth, the\n"
      "dots are events, undistorted onto the same grid: ON red, OFF blue. Events come from edges that move: "
      "where\n"
      "the geometry is right they lie on edges of the frame, and those of silhouettes on bundles of green "
      "lines.\n"
      "\n"
      "Example:\n"
      "  egofocus overlay town1 --out out/overlay --limit 5");
  command->callback([a] { run(*a); });
}

}  // namespace egofocus::app
