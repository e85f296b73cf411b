// A recording against its truth: every method at the time of every truth picture, all metrics, on the same
// pixels.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "recording/depth_metrics.hpp"
#include "recording/eval_method.hpp"
#include "recording/sparsification.hpp"
#include "recording/tick_times.hpp"

namespace egofocus::recording {

/// Which valid truth pixels count. "In ladder": the truth's index (1/g) / step lies in [0.5, D - 1] of the
/// tick's own ladder; none in ticks without a ladder. "Common": every compared method has an estimate there.
/// "Events": an event of the tick's window fell there.
enum PixelSet : std::size_t {
  kAll,
  kEvents,
  kAllInLadder,
  kEventsInLadder,
  kAllCommon,
  kEventsCommon,
};
inline constexpr std::size_t kPixelSets = 6;
inline constexpr std::array<const char*, kPixelSets> kPixelSetNames = {
    "all", "events", "all_in_ladder", "events_in_ladder", "all_common", "events_common"};

struct Mean {
  double sum = 0;
  std::size_t count = 0;
  void add(double value) {
    sum += value;
    ++count;
  }
  void add(const Mean& other) {
    sum += other.sum;
    count += other.count;
  }
  /// NaN where nothing was added.
  [[nodiscard]] double value() const { return sum / static_cast<double>(count); }
};

struct MethodScore {
  std::string method;
  /// Means over the images that have such a pixel.
  std::array<MetricMeans, kPixelSets> sets;
  Mean coverage;         ///< per image: share of the valid truth pixels with an estimate
  Mean events_coverage;  ///< of those with events
  std::size_t images_with_estimate = 0;
  /// Over all valid truth pixels with an estimate; no images where the method has no confidence.
  SparsificationMeans sparsification;
  TickTimes times;  ///< of its engine, where it has one
};

/// One truth image and the tick that it was compared at.
struct ImageFact {
  std::int64_t t_us = 0;
  std::int64_t window_begin_us = 0;
  double step_per_m = 0;        ///< of the ladder; 0: the tick had none
  std::int32_t hypotheses = 0;  ///< of the ladder
  std::uint32_t flags = 0;      ///< FrameFlag bits
  std::array<std::size_t, kPixelSets> pixels{};
};

struct SequenceScore {
  std::string recording;
  std::size_t truth_images = 0;   ///< in the folder: those compared, and the next four
  std::size_t after_events = 0;   ///< later than the last event, where a replay ends
  std::size_t same_time = 0;      ///< of the same time as the one before
  std::size_t without_tick = 0;   ///< on a grid: at no tick's time
  std::size_t over_limit = 0;     ///< left out by max_images
  std::size_t before_events = 0;  ///< of those compared: earlier than the first event, so without an estimate
  double median_m = 0;            ///< of the truth compared with
  std::vector<MethodScore> methods;
  std::vector<ImageFact> images;  ///< what was compared: the rest of truth_images

  [[nodiscard]] std::size_t images_without_ladder() const;
  /// Share of the valid truth outside the ladder, over the images that have a ladder; NaN without any.
  [[nodiscard]] double outside_ladder() const;
};

/// The engines tick at the truth's times, or on a grid (EvalOptions::on_grid).
/// Ladder, window and event pixels are those of the first method that runs an engine; without one, of the
/// focus backend, which then runs for them. Throws Error: as open_folder() and Replay; kFile without truth,
/// kNoEvents when all truth is later than the last event, kUsage when none lies at a tick of the grid.
[[nodiscard]] SequenceScore evaluate(const std::filesystem::path& recording, const EvalOptions& options);

/// Means over all images of all sequences, which were evaluated with the same methods. median_m is 0.
[[nodiscard]] SequenceScore overall(const std::vector<SequenceScore>& sequences);

/// Of a ladder with step_per_m > 0: is the truth's index (1/g) / step in [0.5, D - 1]? Nearer to infinity
/// than half a step, the ladder calls it infinity; no ladder (step 0) has anything inside.
[[nodiscard]] bool in_ladder(double truth_m, double step_per_m, std::int32_t hypotheses);

/// Ticks at a fixed rate: t_k = first_us + floor(k * 10^6 / rate_hz).
struct TickGrid {
  std::int64_t first_us = 0;
  double rate_hz = 20;

  [[nodiscard]] bool has(std::int64_t t_us) const;
};

/// What of the truth, ascending in time, is to be compared when the events end at last_event_us. Times rise
/// strictly; `counts` gets after_events, same_time and without_tick.
[[nodiscard]] std::vector<DepthTruth> plan_truth(const std::vector<DepthTruth>& truth,
                                                 const std::optional<TickGrid>& grid,
                                                 std::int64_t last_event_us, SequenceScore& counts);

}  // namespace egofocus::recording
