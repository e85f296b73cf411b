// The V4L2 source on the kernel's uvcvideo driver and an emulated sensor: grey pixels that are EVT3, full
// buffers with stale bytes behind the marker, unplugging.
#include <unistd.h>

#include <cstring>

#include "hal/v4l2_source.hpp"
#include "hil/camera_bench.hpp"
#include "hil/emulated_uvc.hpp"

using namespace egofocus;
using namespace egofocus::hil;

namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;

V4l2CameraSettings settings_of(const char* path) {
  V4l2CameraSettings settings;
  std::strcpy(settings.device, path);
  settings.has_format = true;
  settings.format = EvtFormat::kEvt3;
  settings.size = {kWidth_px, kHeight_px};
  return settings;
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  constexpr const char* kPath = "/dev/video0";
  CountedEvents feed(kRate_hz, kWidth_px, kHeight_px);
  EmulatedUvc camera(feed);
  CameraBench<V4l2CameraSource> bench(settings_of(kPath), monotonic_clock());
  expect(bench.source.start().code() == StatusCode::kNoDevice, "without a camera there is no device");
  REQUIRE(camera.plug());
  for (int i = 0; i < 1000 && access(kPath, R_OK | W_OK) != 0; ++i) usleep(20'000);
  const Status started = bench.source.start();
  char text[300];
  started.describe(text);
  std::printf("       start: %s\n", text);
  REQUIRE(started.ok());
  expect(bench.source.info().has_marker, "a disguised format is cut at the marker");
  expect(bench.until_event(10'000'000) >= 0, "the first event comes");
  check_stream(bench, kWidth_px, kHeight_px);
  {
    CameraBench<V4l2CameraSource> second(settings_of(kPath), monotonic_clock());
    expect(second.source.start().code() == StatusCode::kDeviceBusy, "a second source is refused");
  }

  for (std::uint64_t i = 1; i <= 5; ++i) {
    camera.unplug();
    while (bench.source.counters().lost < i) bench.poll();
    expect(camera.plug_when_free(), "the kernel takes the camera again");
    bench.drop_events();
    expect(bench.until_event(60'000'000) >= 0, "unplugged and back");
  }
  check_stream(bench, kWidth_px, kHeight_px);
  const V4l2CameraCounters counters = bench.source.counters();
  std::printf("       %llu buffers, %llu lost, %llu refused without marker, %llu damaged\n",
              static_cast<unsigned long long>(counters.buffers),
              static_cast<unsigned long long>(counters.lost_buffers),
              static_cast<unsigned long long>(counters.unmarked_refused),
              static_cast<unsigned long long>(counters.damaged));
  std::uint64_t violations = 0;
  for (const std::uint64_t kind : counters.evt.violations) violations += kind;
  expect(violations == 0 && counters.unmarked_refused == 0, "its EVT3 breaks no rule");
  expect(counters.without_stamp == counters.buffers,
         "uvcvideo's stamps, of the frame's start, are not taken");
  bench.source.stop();
  expect(!camera.time().runs(), "a stop ends the stream");
  camera.unplug();
  return failures != 0;
}
