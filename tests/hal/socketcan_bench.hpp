// A SocketCAN source on a scripted kernel, its rings, and what came out.
#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <tuple>
#include <vector>

#include "core/inlets.hpp"
#include "hal/can_bench.hpp"
#include "hal/dbc_files.hpp"
#include "hal/scripted_can.hpp"
#include "hal/socketcan_source.hpp"

namespace egofocus {

struct CanBench {
  explicit CanBench(const SocketCanConfig& config = {})
      : CanBench(config, bosch(), *read_shipped_dbc("bosch_mm.dbc")) {}
  CanBench(const SocketCanConfig& config, const CanMotionConfig& motion_config, const Dbc& dbc,
           CanTap tap = {})
      : motion(configured(motion_config, dbc)), source(config, *motion, tap, kernel.io()) {}

  static std::unique_ptr<CanMotionDecoder> configured(const CanMotionConfig& config, const Dbc& dbc) {
    auto decoder = std::make_unique<CanMotionDecoder>();
    REQUIRE(decoder->configure(config, dbc).ok());
    return decoder;
  }

  Delivery poll(std::int64_t timeout_us = 10000) { return source.poll(inlets, timeout_us); }
  SocketCanHealth health() const {
    SocketCanHealth result;
    REQUIRE(source.health(result));
    return result;
  }
  std::vector<ImuSample> imu() {
    const auto all = rings.imu.peek(1024);
    std::vector<ImuSample> result(all.begin(), all.end());
    rings.imu.release(all.size());
    return result;
  }

  std::vector<Event> events = std::vector<Event>(2);
  std::vector<ImuSample> imu_storage = std::vector<ImuSample>(1024);
  std::vector<OdometrySample> odometry_storage = std::vector<OdometrySample>(64);
  std::vector<PoseSample> poses = std::vector<PoseSample>(2);
  Inlets::Rings rings{SpscRing<Event>(events), SpscRing<ImuSample>(imu_storage),
                      SpscRing<OdometrySample>(odometry_storage), SpscRing<PoseSample>(poses)};
  Inlets inlets{rings};
  test::ScriptedCan kernel;
  std::unique_ptr<CanMotionDecoder> motion;
  SocketCanSource source;
};

}  // namespace egofocus
