#include "recording/eval_method.hpp"

#include <chrono>
#include <limits>

#include "pipeline/working_grid.hpp"
#include "recording/error.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

std::vector<float> rows_map(const DepthPrior& prior, const Intrinsics& grid, const fs::path& recording) {
  if (prior.row_depth_m.size() != static_cast<std::size_t>(grid.height_px)) {
    throw Error(ExitCode::kConfiguration, "--prior",
                "has " + std::to_string(prior.row_depth_m.size()) + " rows; the grid of " +
                    recording.string() + " has " + std::to_string(grid.height_px) +
                    ". Fit a prior on recordings with this grid.");
  }
  std::vector<float> map;
  for (const double depth : prior.row_depth_m)
    map.insert(map.end(), static_cast<std::size_t>(grid.width_px), static_cast<float>(depth));
  return map;
}

/// The folder of this recording's maps: one of its own name, or the whole where there is no such folder.
fs::path maps_of(const fs::path& maps, const fs::path& recording) {
  std::error_code ignored;
  if (!fs::is_directory(maps, ignored))
    throw Error(ExitCode::kFile, maps.string(), "is no folder. --maps takes a folder of depth pictures.");
  const fs::path own = maps / recording_name(recording);
  return fs::is_directory(own, ignored) ? own : maps;
}

Folder adjusted_folder(const fs::path& recording, const EvalOptions& options) {
  Folder folder = open_folder(recording, options.motion);
  options.adjust(folder.camera.config);
  return folder;
}

}  // namespace

std::string recording_name(const fs::path& recording) {
  const fs::path clean = fs::absolute(recording).lexically_normal();
  return (clean.has_filename() ? clean : clean.parent_path()).filename().string();
}

DepthMap depth_map(const DepthFrame& frame, int min_confidence) {
  DepthMap map;
  map.confidence.assign(frame.confidence.begin(), frame.confidence.end());
  map.depth_m.resize(frame.inverse_depth.size());
  for (std::size_t i = 0; i < map.depth_m.size(); ++i) {
    if (map.confidence[i] < min_confidence) continue;
    const double rho = frame.inverse_depth[i] * frame.inverse_depth_scale_per_m;
    map.depth_m[i] = rho > 0 ? static_cast<float>(1.0 / rho) : std::numeric_limits<float>::infinity();
  }
  return map;
}

EvalMethod::EvalMethod(const std::string& name, const fs::path& recording, const EvalOptions& options)
    : min_confidence_(options.min_confidence) {
  Folder folder = adjusted_folder(recording, options);
  grid_ = working_grid(folder.camera.config);
  if (name == "focus" || name == "focus+sgm") {
    folder.camera.config.backend = Backend::kFocus;
    folder.camera.config.focus.smoothing = name == "focus+sgm";
    replay_ = std::make_unique<Replay>(std::move(folder));
  } else if (name == "network" && (!options.model.empty() || default_backend() == Backend::kNetwork)) {
    folder.camera.config.backend = Backend::kNetwork;
    if (!options.model.empty()) {
      model_.emplace(options.model);
      folder.camera.config.model = model_->bytes();
    }
    replay_ = std::make_unique<Replay>(std::move(folder));
  } else if (name == "median") {
    set_constant(0);
  } else if (name == "median-prior" && options.prior) {
    set_constant(options.prior->median_m);
  } else if (name == "rows" && options.prior) {
    constant_m_ = rows_map(*options.prior, grid_, recording);
  } else if (name == "maps" && !options.maps.empty()) {
    maps_ = maps_of(options.maps, recording);
  } else {
    throw Error(ExitCode::kUsage, "--methods",
                "`" + name +
                    "` is unknown, or lacks its input: network needs --model FILE in a build that embeds "
                    "none, median-prior and "
                    "rows need --prior FILE, maps needs --maps DIR.");
  }
}

void EvalMethod::set_constant(double depth_m) {
  constant_m_.assign(static_cast<std::size_t>(grid_.width_px) * static_cast<std::size_t>(grid_.height_px),
                     static_cast<float>(depth_m));
}

void EvalMethod::start(std::int64_t first_tick_us) {
  if (replay_) replay_->start(first_tick_us);
}

bool EvalMethod::tick() {
  if (!replay_) return true;
  const auto begin = std::chrono::steady_clock::now();
  if (!replay_->tick(frame_)) return false;
  const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin;
  times_.add(frame_, spent.count());
  return true;
}

DepthMap EvalMethod::map(const DepthTruth& truth, const CameraFile& camera) const {
  if (replay_) return depth_map(frame_, min_confidence_);
  if (!constant_m_.empty()) return {constant_m_, {}};
  const fs::path picture = maps_ / truth.path.filename();
  std::error_code ignored;
  if (!fs::exists(picture, ignored)) {
    throw Error(
        ExitCode::kFile, picture.string(),
        "is missing. --maps needs a picture for each truth image; --limit takes the first ones only.");
  }
  return {read_depth({truth.t_us, picture}, camera).pixels, {}};
}

}  // namespace egofocus::recording
