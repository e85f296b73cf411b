// What stands behind the public Inlets: the four rings.
#pragma once

#include "core/ring.hpp"
#include "egofocus/source.hpp"

namespace egofocus {

struct Inlets::Rings {
  SpscRing<Event> events;
  SpscRing<ImuSample> imu;
  SpscRing<OdometrySample> odometry;
  SpscRing<PoseSample> poses;
};

}  // namespace egofocus
