// The methods that an evaluation compares: each gives a depth map for a tick.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "recording/depth_metrics.hpp"
#include "recording/depth_prior.hpp"
#include "recording/model_file.hpp"
#include "recording/replay.hpp"
#include "recording/tick_times.hpp"

namespace egofocus::recording {

/// Names that `egofocus eval --methods` knows.
///   focus        the focus backend, argmax alone
///   focus+sgm    the focus backend with semi-global smoothing
///   network      the network backend, with EvalOptions::model or the embedded model
///   median       the median of this recording's own truth: an oracle that no method has
///   median-prior the median of the training recordings
///   rows         one depth per row, from the training recordings
///   maps         depth pictures of somebody else
inline const std::vector<std::string> kMethodNames = {"focus",        "focus+sgm", "network", "median",
                                                      "median-prior", "rows",      "maps"};

struct EvalOptions {
  std::vector<std::string> methods;
  MetricRange range;
  int min_confidence = 1;             ///< below it a pixel has no estimate; 1..255
  std::size_t max_images = SIZE_MAX;  ///< of each recording, the first ones
  std::optional<DepthPrior> prior;    ///< for median-prior and rows
  std::filesystem::path maps;         ///< for maps: pictures named like the truth
  std::filesystem::path model;        ///< for network: a model file; empty: the embedded model
  /// Maps and masks, for numpy: each recording's folder appears there whole or not at all. Empty: nowhere.
  std::filesystem::path out;
  std::optional<MotionSource> motion;
  bool on_grid = false;  ///< ticks at the configured rate; else one at the time of each truth picture
  std::optional<std::int64_t> first_tick_us;             ///< of the grid; default: the first truth
  std::function<void(Config&)> adjust = [](Config&) {};  ///< before the engines are made
  std::function<void(std::size_t, std::size_t)> progress = [](std::size_t, std::size_t) {};
};

/// One map of a method, as large as the grid. Metres: 0 is no estimate, infinity is one.
struct DepthMap {
  std::vector<float> depth_m;
  std::vector<std::uint8_t> confidence;  ///< empty where the method has none
};

/// Of a frame; pixels with less confidence have no estimate.
[[nodiscard]] DepthMap depth_map(const DepthFrame& frame, int min_confidence);

/// One of the methods, on one recording.
class EvalMethod {
 public:
  /// Throws Error as Replay does, kUsage for an unknown name or a missing input, kConfiguration when a prior
  /// does not fit.
  EvalMethod(const std::string& name, const std::filesystem::path& recording, const EvalOptions& options);

  /// This depth everywhere; for the method `median`, which is known only when the truth is.
  void set_constant(double depth_m);

  /// The engine behind it; none for constants and pictures.
  [[nodiscard]] Replay* replay() const { return replay_.get(); }
  [[nodiscard]] const DepthFrame& frame() const { return frame_; }

  void start(std::int64_t first_tick_us);

  void set_next_tick(std::int64_t t_us) {
    if (replay_) replay_->set_next_tick(t_us);
  }

  /// The next tick. False at the end of the recording; never without an engine.
  bool tick();
  [[nodiscard]] const TickTimes& times() const { return times_; }

  /// For the tick that the engines are at. Throws Error when a picture is missing or does not fit.
  [[nodiscard]] DepthMap map(const DepthTruth& truth, const CameraFile& camera) const;

 private:
  std::optional<ModelFile> model_;
  std::unique_ptr<Replay> replay_;
  DepthFrame frame_;
  TickTimes times_;
  int min_confidence_;
  Intrinsics grid_;
  std::vector<float> constant_m_;
  std::filesystem::path maps_;
};

/// The last part of a recording's path: its name in tables and folders.
[[nodiscard]] std::string recording_name(const std::filesystem::path& recording);

}  // namespace egofocus::recording
