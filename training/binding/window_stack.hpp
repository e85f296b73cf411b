// One window of events as the network sees it, made by the steps of the runtime's own tick: filter, window,
// ladder, warp. Training and runtime share this code, so their inputs cannot drift apart.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "arena_memory.hpp"
#include "core/arena.hpp"
#include "core/worker_pool.hpp"
#include "egofocus/config.hpp"
#include "network_input.hpp"
#include "pipeline/event_filter.hpp"
#include "pipeline/event_window.hpp"
#include "pipeline/hypothesis_ladder.hpp"
#include "pipeline/motion_track.hpp"
#include "pipeline/warp.hpp"

namespace egofocus::training {

/// A part of the working grid, in pixels. Width 0: all of it.
struct Crop {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t width = 0;
  std::int32_t height = 0;
};

/// The motion between two times into the track; false where it is not known.
using TrackFunction = std::function<bool(std::int64_t begin_us, std::int64_t end_us, MotionTrack& out)>;

/// Depth of the classical backend on the same stack: pixels of the crop, row-major.
struct ClassicalDepth {
  std::vector<std::uint16_t> index_q8;   ///< hypothesis at 1/256 bin
  std::vector<std::uint8_t> confidence;  ///< 0: no estimate
};

/// Thread: one. Uses the heap, and throws recording::Error (kConfiguration) for what check_config() refuses
/// and for a crop outside the grid.
class WindowStack {
 public:
  /// The ladder is that of the whole grid, whatever the crop. `rays`: what fill_rays() made of this camera;
  /// empty: made here, which takes longer than everything else.
  WindowStack(const Config& config, const Crop& crop, std::span<const Ray> rays = {});

  /// Times must not fall. Through the event filter into the window; false where the filter kept it back.
  bool add(const Event& event) noexcept;

  /// Ladder, selection, warp and votes of the window that ends at tick_us and is nowhere older than
  /// oldest_us. False, and no stack: motion unknown, no parallax, or no events.
  bool run(std::int64_t oldest_us, std::int64_t tick_us, const TrackFunction& track);

  /// Of the last run(); count and step are 0 where motion is unknown or without parallax.
  [[nodiscard]] const HypothesisLadder& ladder() const noexcept { return ladder_; }
  /// Events warped.
  [[nodiscard]] std::uint32_t events() const noexcept { return selection_.count; }
  [[nodiscard]] const EventWindow::Selection& selection() const noexcept { return selection_; }
  [[nodiscard]] const EventWindow& window() const noexcept { return window_; }
  /// The camera's centre at the window's begin, seen at its end, metres.
  [[nodiscard]] const double* baseline_m() const noexcept { return track_.knots[0].centre_m; }
  [[nodiscard]] const Warp& warp() const noexcept { return warp_; }
  /// The crop, with its own principal point.
  [[nodiscard]] const Intrinsics& grid() const noexcept { return crop_config_.grid; }
  [[nodiscard]] const Config& config() const noexcept { return config_; }

  /// Focus costs, with or without semi-global smoothing, and the decoder. After a run() that said true.
  [[nodiscard]] ClassicalDepth classical(bool smoothing);
  /// What the network is told of the stack. After a run() that said true.
  [[nodiscard]] NetworkInput input(const FocusInputConfig& config);

 private:
  static Config checked(const Config& config);
  static Config cropped(const Config& config, const Crop& crop);
  static std::size_t bytes_needed(const Config& config, const Config& crop_config);

  Config config_;
  Config crop_config_;
  Intrinsics whole_grid_;
  ArenaMemory memory_;
  Arena arena_;
  EventFilter filter_;
  EventWindow window_;
  Warp warp_;
  WorkerPool pool_;  // one part: this thread
  HypothesisLadder ladder_;
  EventWindow::Selection selection_;
  MotionTrack track_{};
};

}  // namespace egofocus::training
