// Counters and states that explain every missing or poor depth. A snapshot; see Engine::health().
#pragma once

#include <cstdint>

#include "egofocus/export.hpp"

namespace egofocus {

enum class RunState : std::uint8_t {
  kWaiting,  ///< started, nothing has come in yet
  kRunning,
  kDegraded,  ///< depth comes, but with flags; see `cause`
  kStalled,   ///< no depth; see `cause`
};

/// The most important reason for a state other than kRunning, worst first.
enum class Cause : std::uint8_t {
  kNone,
  kNoEvents,
  kNoMotion,
  kStaleVelocity,
  kNoParallax,
  kTooFewEvents,
  kOverload,
};

/// Every item that entered is in exactly one of the lines below its "in" line.
struct EventCounters {
  std::uint64_t in = 0;            ///< came in
  std::uint64_t ring_dropped = 0;  ///< ring full
  std::uint64_t over_rate = 0;     ///< thinned: RingConfig::max_event_rate_hz
  std::uint64_t out_of_range = 0;  ///< x or y outside the sensor
  std::uint64_t out_of_order = 0;  ///< older than its predecessor
  std::uint64_t ahead = 0;         ///< kMonotonic: more than a second after the tick, a clock gone wrong
  std::uint64_t late = 0;          ///< arrived after its tick had run, or a time before -2^60 us
  std::uint64_t hot_pixel = 0;
  std::uint64_t refractory = 0;
  std::uint64_t isolated = 0;
  std::uint64_t kept = 0;  ///< went into the window
};

struct SampleCounters {
  std::uint64_t in = 0;  ///< offered to the ring
  std::uint64_t ring_dropped = 0;
  std::uint64_t late = 0;
  /// Not finite, or beyond the configured plausible range; kMonotonic: more than a second after the tick.
  std::uint64_t invalid = 0;
  std::uint64_t used = 0;
  std::uint64_t rejected = 0;  ///< failed the innovation gate of the ego-motion filter (also in used)
};

struct WindowCounters {
  std::uint64_t outside_motion = 0;  ///< events of a window that lie before the first motion sample
  std::uint64_t decimated = 0;       ///< events left out of a warp because the window held more than N
  std::uint64_t behind_camera =
      0;  ///< event-hypothesis pairs without a vote: point behind the reference view, or far off any grid
};

struct TickCounters {
  std::uint64_t run = 0;
  std::uint64_t late = 0;     ///< began after the deadline
  std::uint64_t skipped = 0;  ///< grid points that were passed over because a tick took too long
  std::uint64_t no_parallax = 0;
  std::uint64_t too_few_events = 0;
  std::uint64_t stale_velocity = 0;
  std::uint64_t no_motion = 0;
  std::uint64_t carried = 0;  ///< of no_parallax and too_few_events: the last measured depth was shown
};

/// Where the time of the last tick that gave depth went, on the host's monotonic clock. The only numbers here
/// that a replay does not repeat.
struct StageTimes {
  std::uint32_t motion_us = 0;   ///< ego-motion, ladder, choice of the window's events
  std::uint32_t warp_us = 0;     ///< events cast onto the hypotheses; kNetwork: and the sums of its input
  std::uint32_t input_us = 0;    ///< kNetwork: sharpness and context; kFocus: 0
  std::uint32_t backend_us = 0;  ///< the network, or focus costs and smoothing
  std::uint32_t depth_us = 0;    ///< cells to pixels
  std::uint32_t all_us = 0;      ///< of these; without samples' way in
};

/// What the system refused at start(); the engine runs without it, with worse worst-case latency.
enum RealTimeRefusal : std::uint32_t {
  kRefusedPriority = 1u << 0,    ///< SCHED_FIFO: give the process CAP_SYS_NICE or an rtprio limit
  kRefusedMemoryLock = 1u << 1,  ///< mlockall: raise the memlock limit
  kRefusedPin = 1u << 2,         ///< CPU pin: the processor does not exist or is not allowed
};

struct Health {
  RunState state = RunState::kWaiting;
  Cause cause = Cause::kNone;
  EventCounters events;
  SampleCounters imu;
  SampleCounters odometry;
  SampleCounters poses;
  WindowCounters window;
  TickCounters ticks;
  StageTimes stages;
  std::uint32_t refused = 0;  ///< RealTimeRefusal bits
  std::uint32_t sources_lost =
      0;  ///< attached sources whose poll() ended with an error, such as a lost device
};

/// Static texts, for logs and tables. Thread: any. RT: yes.
EGOFOCUS_API const char* to_string(RunState state) noexcept;
EGOFOCUS_API const char* to_string(Cause cause) noexcept;
/// One bit: what was refused, and the remedy.
EGOFOCUS_API const char* to_string(RealTimeRefusal refusal) noexcept;

}  // namespace egofocus
