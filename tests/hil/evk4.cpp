// The USB camera source against an emulated EVK4: its requests and registers, EVT3, unplugging.
#include <unistd.h>

#include "hil/emulated_evk4.hpp"
#include "hil/usb_bench.hpp"

using namespace egofocus;
using namespace egofocus::hil;

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  REQUIRE(system_usb() != nullptr);
  CountedEvents feed(kRate_hz, EmulatedEvk4::kWidth_px, EmulatedEvk4::kHeight_px);
  EmulatedEvk4 camera(feed);
  expect(camera.plug(), "the kernel takes the camera");
  for (int i = 0; i < 100 && survey_one().code() == StatusCode::kNoDevice; ++i) usleep(100'000);
  expect(survey_one().ok(), "the survey finds it ready");

  const UsbCameraSettings settings;
  Bench bench(settings);
  REQUIRE(bench.source.start().ok());
  expect(bench.source.info().size.width_px == EmulatedEvk4::kWidth_px, "it is an IMX636");
  expect(bench.until_event(60'000'000) >= 0, "the first event comes");
  check_stream(bench, EmulatedEvk4::kWidth_px, EmulatedEvk4::kHeight_px);
  const UsbCameraCounters counters = bench.source.counters();
  std::uint64_t violations = 0;
  for (const std::uint64_t kind : counters.evt.violations) violations += kind;
  expect(violations == 0, "its EVT3 breaks no rule");

  for (int i = 1; i <= 3; ++i) {
    camera.unplug();
    while (bench.source.counters().lost < static_cast<std::uint64_t>(i)) bench.poll();
    bool is_plugged = false;
    for (int k = 0; k < 200 && !is_plugged; ++k) {
      is_plugged = camera.plug();
      bench.poll();
    }
    bench.drop_events();
    expect(is_plugged && bench.until_event(60'000'000) >= 0, "unplugged and back");
  }
  bench.source.stop();
  expect(!camera.time().runs(), "a stop switches its read-out off");
  camera.unplug();
  return failures != 0;
}
