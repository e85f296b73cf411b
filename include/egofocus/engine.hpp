// The one class a user must know: configure, feed or attach, start, tick, take the newest depth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/config.hpp"
#include "egofocus/export.hpp"
#include "egofocus/health.hpp"
#include "egofocus/source.hpp"
#include "egofocus/status.hpp"
#include "egofocus/types.hpp"

namespace egofocus {

struct Model;

/// Which clock paces the ticks.
enum class ClockKind : std::uint8_t {
  kVirtual,    ///< time is what the samples say: tick() waits for data, not for the clock (replay, tests)
  kMonotonic,  ///< CLOCK_MONOTONIC: tick() sleeps to its absolute deadline; sources poll on their own threads
  kDevice,  ///< time is what live devices say, all by one clock: tick() polls them until each has delivered
            ///< so far
};

/// What the arena is for, in bytes; `all` is the sum of the others.
struct ArenaBytes {
  std::size_t all = 0;
  std::size_t engine = 0;  ///< the objects themselves
  std::size_t rings = 0;   ///< samples on their way to the tick
  std::size_t window = 0;  ///< events a tick may look back on, and the filter's memory of pixels
  std::size_t motion = 0;  ///< ego-motion
  std::size_t warp = 0;    ///< the camera's rays, scratch of votes; kFocus: landing lines and the stack
  std::size_t backend =
      0;  ///< kFocus: costs; kNetwork: landing lines, stack, input and activations, which share
  std::size_t weights = 0;  ///< kNetwork: packed for the instruction set in use
  std::size_t depth = 0;    ///< frames: one published, one read, one written, one kept to be carried
};

/// Events and motion in, one depth map per tick out.
///
/// Order of calls: configure -> [attach ...] -> start -> tick, tick, ... -> stop. After start() no call
/// allocates, locks, throws, logs or waits without bound.
/// Thread: one thread owns the engine and calls configure, attach, start, set_next_tick, tick, stop. inlets()
/// may be written by others (see Inlets). newest() may be called from ONE other thread, health() from any.
class EGOFOCUS_API Engine {
 public:
  Engine() noexcept = default;
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// The exact number of bytes that configure() takes from the arena, or the reason why the configuration
  /// cannot be. RT: no.
  static Status required_arena(const Config& config, std::size_t& bytes_out) noexcept;
  static Status required_arena(const Config& config, ArenaBytes& bytes_out) noexcept;

  /// Checks everything and plans the arena. On failure nothing is left half-started. `arena` must start at a
  /// multiple of 64 bytes and outlive the engine. RT: no.
  Status configure(const Config& config, std::span<std::byte> arena) noexcept;

  /// Up to 8 sources, before start(). RT: no.
  Status attach(const Source& source) noexcept;

  /// Shows all events that come in to `tap`, before start(). Its object must outlive the engine. RT: no.
  Status watch_events(const EventTap& tap) noexcept;

  /// `first_tick_us` is t_0 of the tick grid. Starts sources and threads. RT: no.
  Status start(ClockKind clock, std::int64_t first_tick_us) noexcept;

  /// The time that the next tick is about.
  [[nodiscard]] std::int64_t next_tick_us() const noexcept;

  /// kVirtual: the next tick is about `t_us` instead, sooner or later than the grid says, and the grid goes
  /// on from there. Depth does not depend on when else there were ticks: samples are used by their own times.
  /// Likewise kDevice. Errors, which change nothing: kBadState before start(), after stop() and with
  /// kMonotonic; kBadTick when
  /// `t_us` is not after the last tick (value, bound = its time) or above 2^60. Thread: the tick's. RT: yes.
  Status set_next_tick(std::int64_t t_us) noexcept;

  /// One step: ingest -> ego-motion -> warp -> focus -> depth, and publication. A frame is published each
  /// time. Returns false, and does nothing, when all attached sources ended before the tick's time
  /// (kVirtual, kDevice), after request_stop(), and when the engine is not started. kDevice: waits for the
  /// sources, however long, until request_stop(). RT: yes.
  bool tick() noexcept;

  /// The newest published frame; false before the first. RT: yes.
  bool newest(DepthFrame& frame_out) noexcept;

  /// Writing ends for callers that feed spans.
  [[nodiscard]] Inlets inlets() noexcept;

  /// Snapshot of the counters. RT: yes.
  [[nodiscard]] Health health() const noexcept;

  /// The kernels chosen at configure() with their instruction sets: "warp_vote avx512, conv_u8s8 avx512vnni";
  /// empty before. RT: yes.
  [[nodiscard]] const char* isa() const noexcept;

  /// May be called from any thread or a signal handler.
  void request_stop() noexcept;
  void stop() noexcept;

 private:
  struct State;
  static Status plan(Config& config, Model& model, ArenaBytes& bytes_out) noexcept;

  State* state_ = nullptr;
};

}  // namespace egofocus
