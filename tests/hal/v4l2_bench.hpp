// A V4L2 source on a scripted kernel, its ring, and what came out; frames of events in each encoding.
#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <vector>

#include "core/inlets.hpp"
#include "hal/scripted_v4l2.hpp"
#include "hal/v4l2_source.hpp"
#include "made_evt_words.hpp"

namespace egofocus {

inline evt_words::Bytes operator+(evt_words::Bytes a, const evt_words::Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// EVT3: time, one event at (x, y), and the time again as sensors repeat it. 0 <= t_us < 2^24.
inline evt_words::Bytes evt3_event(std::uint32_t t_us, std::uint32_t x, std::uint32_t y) {
  using namespace evt_words::evt3;
  return stream({time_high(t_us >> 12), time_low(t_us & 0xfff), addr_y(y), addr_x(1, x)});
}
// The sensor's 64-bit marker.
inline evt_words::Bytes marker() {
  return evt_words::evt3::stream({0xE019, 0xE019, 0xE019, 0xE019});
}

struct V4l2Bench {
  explicit V4l2Bench(const V4l2CameraSettings& settings = small())
      : copy(V4l2CameraSource::buffer_bytes(settings)),
        source(std::make_unique<V4l2CameraSource>(settings, copy, kernel.time.clock(), kernel.io())) {}

  static V4l2CameraSettings small() {
    V4l2CameraSettings settings;
    settings.frame_bytes = 16384;
    settings.buffers = 4;
    return settings;
  }
  // As a Raspberry Pi 5 has it: grey pixels, buffers always full, the marker switched on.
  void disguise() {
    kernel.fourcc = V4L2_PIX_FMT_GREY;
    kernel.controls["/dev/v4l-subdev2"].push_back({.name = "evt_format",
                                                   .id = 0x00980901,
                                                   .type = V4L2_CTRL_TYPE_MENU,
                                                   .maximum = 2,
                                                   .value = 2,
                                                   .menu = {"EVT2", "EVT21", "EVT3"}});
    kernel.controls["/dev/v4l-subdev2"].push_back({.name = "Enable End of Frame Marker",
                                                   .id = 0x00982900,
                                                   .type = V4L2_CTRL_TYPE_MENU,
                                                   .maximum = 4,
                                                   .value = 3,
                                                   .menu = {}});
  }

  void start() {
    const Status status = source->start();
    INFO(status.subject());
    REQUIRE(status.ok());
  }
  Delivery poll(std::int64_t timeout_us = 10'000) { return source->poll(inlets, timeout_us); }
  void pass(std::int64_t us) { kernel.time.set(kernel.time.now_us() + us); }
  // The first frame gives the clock its first pair; its own events cannot be mapped yet.
  void start_with_clock() {
    start();
    kernel.frame(evt_words::evt3::stream({evt_words::evt3::time_high(0), evt_words::evt3::time_low(0)}) +
                 (kernel.fourcc == V4L2_PIX_FMT_GREY ? marker() : evt_words::Bytes{}));
    poll();
    REQUIRE(source->counters().decoded == 1);
    base_us = kernel.time.now_us();
    REQUIRE(events().empty());
  }
  std::vector<Event> events() {
    std::vector<Event> result;
    for (auto ready = rings.events.peek(65536); !ready.empty(); ready = rings.events.peek(65536)) {
      result.insert(result.end(), ready.begin(), ready.end());
      rings.events.release(ready.size());
    }
    return result;
  }
  std::vector<int> columns() {
    std::vector<int> x;
    for (const Event& event : events()) x.push_back(event.x);
    return x;
  }

  std::vector<Event> event_storage = std::vector<Event>(4096);
  std::vector<ImuSample> imu = std::vector<ImuSample>(2);
  std::vector<OdometrySample> odometry = std::vector<OdometrySample>(2);
  std::vector<PoseSample> poses = std::vector<PoseSample>(2);
  Inlets::Rings rings{SpscRing<Event>(event_storage), SpscRing<ImuSample>(imu),
                      SpscRing<OdometrySample>(odometry), SpscRing<PoseSample>(poses)};
  Inlets inlets{rings};
  test::ScriptedV4l2 kernel;
  std::int64_t base_us = 0;  // host time of device time 0
  std::vector<std::byte> copy;
  std::unique_ptr<V4l2CameraSource> source;
};

}  // namespace egofocus
