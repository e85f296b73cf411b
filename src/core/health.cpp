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

}  // namespace egofocus
