// What stands behind the public Inlets: the four rings.
#pragma once

#include <atomic>

#include "core/event_thinner.hpp"
#include "core/ring.hpp"
#include "egofocus/source.hpp"

namespace egofocus {

struct Inlets::Rings {
  SpscRing<Event> events;
  SpscRing<ImuSample> imu;
  SpscRing<OdometrySample> odometry;
  SpscRing<PoseSample> poses;
  EventThinner thinner{0};                  // in front of `events`, on its writer's thread
  EventTap tap = {};                        // in front of that
  std::atomic<std::uint64_t> over_rate{0};  // taken out by it
};

}  // namespace egofocus
