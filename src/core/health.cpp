#include "egofocus/health.hpp"

namespace egofocus {

const char* to_string(RunState state) noexcept {
  switch (state) {
    case RunState::kWaiting:
      return "waiting";
    case RunState::kRunning:
      return "running";
    case RunState::kDegraded:
      return "degraded";
    case RunState::kStalled:
      return "stalled";
  }
  return "unknown";
}

const char* to_string(Cause cause) noexcept {
  switch (cause) {
    case Cause::kNone:
      return "none";
    case Cause::kNoEvents:
      return "no events";
    case Cause::kNoMotion:
      return "no motion samples";
    case Cause::kStaleVelocity:
      return "stale velocity";
    case Cause::kNoParallax:
      return "no parallax";
    case Cause::kTooFewEvents:
      return "too few events";
    case Cause::kOverload:
      return "overload";
  }
  return "unknown";
}

const char* to_string(RealTimeRefusal refusal) noexcept {
  switch (refusal) {
    case kRefusedPriority:
      return "SCHED_FIFO was refused: give the process CAP_SYS_NICE or raise rtprio in limits.conf";
    case kRefusedMemoryLock:
      return "mlockall was refused: raise memlock in limits.conf";
    case kRefusedPin:
      return "the CPU pin was refused: choose a processor that exists and is allowed";
  }
  return "unknown";
}

}  // namespace egofocus
