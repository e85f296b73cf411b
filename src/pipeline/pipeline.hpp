// One tick, step by step. pipeline.cpp's tick() is the algorithm on one screen.
#pragma once

#include <cstdint>
#include <optional>

#include "core/arena.hpp"
#include "core/inlets.hpp"
#include "core/worker_pool.hpp"
#include "egofocus/config.hpp"
#include "egofocus/health.hpp"
#include "kernels/kernel_table.hpp"
#include "pipeline/carried_depth.hpp"
#include "pipeline/depth_decode.hpp"
#include "pipeline/ego_motion.hpp"
#include "pipeline/event_filter.hpp"
#include "pipeline/event_window.hpp"
#include "pipeline/focus.hpp"
#include "pipeline/fused_depth.hpp"
#include "pipeline/hypothesis_ladder.hpp"
#include "pipeline/network_backend.hpp"
#include "pipeline/stage_watch.hpp"
#include "pipeline/velocity_noise.hpp"
#include "pipeline/warp.hpp"

namespace egofocus {

/// Where a tick writes: a frame whose spans view the two arrays.
struct FrameSlot {
  DepthFrame frame;
  std::span<std::uint16_t> inverse_depth;
  std::span<std::uint8_t> confidence;
};

/// Thread: the tick's. RT: yes, but the constructor and prepare().
class Pipeline {
 public:
  /// `model`: that of adopt_model(), for Backend::kNetwork alone; read here only.
  Pipeline(const Config& config, const Model& model, const KernelTable& kernels, Arena& arena) noexcept;
  void prepare(const Config& config) noexcept;

  /// Takes from the rings what has t <= tick_us; what is newer stays there. Events more than `ahead_us` newer
  /// than the tick are counted and dropped, or they would block the ring. Returns the number of samples
  /// taken.
  std::uint64_t ingest(Inlets::Rings& rings, std::int64_t tick_us, std::int64_t ahead_us) noexcept;

  /// Window -> ego-motion -> warp -> focus -> depth. Fills all of `out` but latency and sequence.
  void tick(std::int64_t tick_us, WorkerPool& pool, FrameSlot& out) noexcept;

  /// Counters of everything behind the rings, and the state after the last tick.
  void report(Health& health) const noexcept;

  [[nodiscard]] std::int64_t newest_event_us() const noexcept { return window_.newest_us(); }
  /// -2^60 before the first.
  [[nodiscard]] std::int64_t last_tick_us() const noexcept { return last_tick_us_; }

 private:
  // Older time stamps are garbage; so far from the ends that differences of times never overflow.
  static constexpr std::int64_t kBeginOfTime_us = -(std::int64_t{1} << 60);

  std::uint64_t ingest_events(SpscRing<Event>& ring, std::int64_t tick_us, std::int64_t horizon_us) noexcept;
  void count_outside_motion(std::int64_t oldest_us, std::int64_t known_from_us,
                            std::int64_t tick_us) noexcept;
  /// The motion from begin_us to the tick into `track_`; false where it is not known. oldest_us: as far back
  /// as this tick looks.
  bool track(std::int64_t oldest_us, std::int64_t begin_us, std::int64_t tick_us) noexcept;
  /// Keeps up with the way since the kept depth, or drops it where the motion is not known.
  void follow(bool has_motion, std::int64_t tick_us) noexcept;
  /// The kept depth as seen at the tick; false where there is none.
  bool carry(std::int64_t tick_us, FrameSlot& out) noexcept;
  /// Events -> warped images -> the backend's cells.
  CellDepth depth_of_cells(const EventWindow::Selection& selection, const HypothesisLadder& ladder,
                           WorkerPool& pool, StageWatch& watch, StageTimes& stages) noexcept;
  /// The backend's cells together with those of earlier ticks.
  CellDepth fuse(const CellDepth& cells, const HypothesisLadder& ladder, std::int64_t oldest_us,
                 std::int64_t tick_us, WorkerPool& pool) noexcept;
  void blank(FrameSlot& out) noexcept;
  void conclude(const DepthFrame& frame) noexcept;

  Config config_;
  Intrinsics grid_;
  EventFilter filter_;
  EventWindow window_;
  EgoMotion* ego_motion_;  // large: in the arena
  MotionTrack* track_;
  std::optional<NetworkMemory> network_memory_;
  Warp warp_;
  std::optional<Focus> focus_;  // one of the two backends
  std::optional<NetworkBackend> network_;
  std::optional<FusedDepth> fused_;  // with the network, where asked for
  DepthDecode depth_decode_;
  CarriedDepth carried_;

  std::int64_t last_tick_us_ = kBeginOfTime_us;
  std::int64_t last_depth_event_us_ = INT64_MIN;
  std::uint64_t lost_before_tick_ = 0;  // as of the last tick
  std::uint64_t lost_before_ring_ = 0;
  std::uint64_t ahead_[3] = {0, 0, 0};  // samples of IMU, odometry, poses too far in the future
  std::uint64_t outside_until_ = 0;     // events up to this number are already counted as outside the motion
  WindowCounters window_counters_;
  TickCounters tick_counters_;
  StageTimes stages_;
  RunState state_ = RunState::kWaiting;
  Cause cause_ = Cause::kNone;
};

}  // namespace egofocus
