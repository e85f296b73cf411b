// The real source, over the real libusb and kernel, against an emulated DAVIS346. Prints what was measured.
#include <dirent.h>
#include <unistd.h>

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "core/clock.hpp"
#include "core/inlets.hpp"
#include "hal/usb_camera_source.hpp"
#include "hal/usb_survey.hpp"
#include "hil/emulated_davis.hpp"

using namespace egofocus;

namespace {

constexpr double kRate_hz = 20'000;

int failures = 0;

void expect(bool condition, const char* what) {
  if (!condition) ++failures;
  std::printf("%s %s\n", condition ? "ok    " : "FAILED", what);
}

std::int64_t now_us() {
  const Clock clock = monotonic_clock();
  return clock.now_us(clock.self);
}

/// Resident memory in kB, and open descriptors.
long resident_kb() {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("VmRSS:", 0) == 0) return std::stol(line.substr(6));
  }
  return -1;
}
int open_files() {
  int count = 0;
  DIR* folder = opendir("/proc/self/fd");
  while (readdir(folder) != nullptr) ++count;
  closedir(folder);
  return count;
}

struct Bench {
  explicit Bench(const UsbCameraSettings& settings)
      : buffers(UsbCameraSource::buffer_bytes(settings)),
        source(settings, buffers, *system_usb(), monotonic_clock()) {}
  std::vector<std::byte> buffers;
  std::vector<Event> event_slots = std::vector<Event>(1 << 16);
  std::vector<ImuSample> imu_slots = std::vector<ImuSample>(1 << 12);
  std::vector<OdometrySample> odometry_slots = std::vector<OdometrySample>(64);
  std::vector<PoseSample> pose_slots = std::vector<PoseSample>(64);
  Inlets::Rings rings{SpscRing<Event>(event_slots), SpscRing<ImuSample>(imu_slots),
                      SpscRing<OdometrySample>(odometry_slots), SpscRing<PoseSample>(pose_slots)};
  Inlets inlets{rings};
  UsbCameraSource source;
  std::int64_t longest_poll_us = 0;

  void poll() {
    const std::int64_t begin_us = now_us();
    static_cast<void>(source.poll(inlets, 10'000));
    longest_poll_us = std::max(longest_poll_us, now_us() - begin_us);
  }
  template <typename Take>
  void take_events(Take take) {
    for (auto some = rings.events.peek(1 << 16); !some.empty(); some = rings.events.peek(1 << 16)) {
      for (const Event& event : some) take(event);
      rings.events.release(some.size());
    }
  }
  /// Polls until an event has come; the time that it took, or -1 after `limit_us`.
  std::int64_t until_event(std::int64_t limit_us) {
    const std::int64_t begin_us = now_us();
    while (now_us() - begin_us < limit_us) {
      poll();
      if (rings.events.offered() == seen) continue;
      drop_events();
      return now_us() - begin_us;
    }
    return -1;
  }
  void drop_events() {
    take_events([](const Event&) {});
    rings.imu.release(rings.imu.peek(1 << 12).size());
    seen = rings.events.offered();
  }
  std::uint64_t seen = 0;
};

Status survey_one() {
  UsbSighting sighting;
  std::size_t found = 0;
  if (const Status status = survey_usb(*system_usb(), {&sighting, 1}, found); !status.ok()) return status;
  if (found != 1) return {StatusCode::kNoDevice, "survey", static_cast<std::int64_t>(found)};
  std::printf("       %s, serial %s, %s\n", sighting.info.name, sighting.info.serial,
              sighting.status.ok() ? "ready" : sighting.status.subject());
  return sighting.status;
}

// One second of stream: nothing missing, nothing out of order, host times that are true.
void check_stream(Bench& bench, const hil::EmulatedDavis& camera) {
  bench.drop_events();
  std::uint64_t events = 0;
  std::uint64_t gaps = 0;
  std::uint64_t backwards = 0;
  std::int64_t last = -1;
  std::int64_t last_us = 0;
  std::int64_t longest_age_us = 0;
  const std::int64_t begin_us = now_us();
  while (now_us() - begin_us < 1'000'000) {
    bench.poll();
    const std::int64_t at_us = now_us();
    bench.take_events([&](const Event& event) {
      const std::int64_t place = event.y * hil::EmulatedDavis::kWidth_px + event.x;
      constexpr std::int64_t kPlaces = hil::EmulatedDavis::kWidth_px * hil::EmulatedDavis::kHeight_px;
      if (last >= 0 && place != (last + 1) % kPlaces) ++gaps;
      if (event.polarity != place % 2) ++gaps;
      if (event.t_us < last_us) ++backwards;
      longest_age_us = std::max(longest_age_us, at_us - event.t_us);
      last = place;
      last_us = event.t_us;
      ++events;
    });
  }
  const double seconds = static_cast<double>(now_us() - begin_us) / 1e6;
  std::printf("       %" PRIu64 " events in %.2f s, %" PRIu64 " gaps, oldest on arrival %" PRId64
              " us, longest poll %" PRId64 " us\n",
              events, seconds, gaps, longest_age_us, bench.longest_poll_us);
  expect(static_cast<double>(events) > 0.8 * kRate_hz, "events come at the camera's rate");
  expect(gaps == 0, "no event is missing");
  expect(backwards == 0, "times never go back");
  expect(longest_age_us < 500'000, "host times are near the host's clock");
  std::vector<ImuSample> imu(1 << 12);
  const std::span<const ImuSample> samples = bench.rings.imu.peek(1 << 12);
  std::printf("       %zu IMU samples\n", samples.size());
  expect(samples.size() > 100, "IMU samples come");
  expect(!samples.empty() && samples[0].accel_m_s2[0] > 9.8 && samples[0].accel_m_s2[0] < 9.82,
         "and are in SI");
  bench.rings.imu.release(samples.size());
  static_cast<void>(camera);
}

// The kernel needs a moment to give the port free.
bool plugged_again(Bench& bench, hil::EmulatedDavis& camera) {
  for (int i = 0; i < 200; ++i) {
    if (camera.plug()) return true;
    bench.poll();
  }
  return false;
}

void check_reopening(Bench& bench, hil::EmulatedDavis& camera) {
  long first_kb = 0;
  int first_files = 0;
  std::int64_t longest_us = 0;
  int back = 0;
  for (int i = 0; i < 20; ++i) {
    camera.unplug();
    for (int k = 0; k < 1 + i % 5; ++k) bench.poll();
    bool is_plugged = plugged_again(bench, camera);
    if (i % 4 == 3) {  // again, while it is being started
      for (int k = 0; k < 20; ++k) bench.poll();
      camera.unplug();
      bench.poll();
      is_plugged = plugged_again(bench, camera);
    }
    bench.drop_events();
    const std::int64_t took_us = is_plugged ? bench.until_event(10'000'000) : -1;
    back += took_us >= 0;
    longest_us = std::max(longest_us, took_us);
    if (i == 2) {
      first_kb = resident_kb();
      first_files = open_files();
    }
  }
  const long last_kb = resident_kb();
  const UsbCameraCounters counters = bench.source.counters();
  std::printf("       back %d times of 20, %.2f s at most; lost %" PRIu64 ", opened %" PRIu64
              ", refused %" PRIu64 "; memory %ld -> %ld kB, files %d -> %d\n",
              back, static_cast<double>(longest_us) / 1e6, counters.lost, counters.opened, counters.refused,
              first_kb, last_kb, first_files, open_files());
  expect(back == 20, "unplugged and back 20 times");
  expect(open_files() == first_files, "no descriptor is left behind");
  expect(last_kb <= first_kb + first_kb / 100 + 16, "memory stays within 1 %");
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (system_usb() == nullptr) {
    std::puts("FAILED this build has no USB");
    return 1;
  }
  expect(survey_one().code() == StatusCode::kNoDevice, "an empty bus has no camera");
  hil::EmulatedDavis camera(kRate_hz);
  expect(camera.plug(), "the kernel takes the camera");
  std::int64_t waited_us = now_us();
  while (survey_one().code() == StatusCode::kNoDevice && now_us() - waited_us < 10'000'000) usleep(100'000);
  expect(survey_one().ok(), "the survey finds it ready");
  camera.set_logic_version(19);
  expect(survey_one().code() == StatusCode::kUnknownFirmware, "another logic version is refused");
  camera.set_logic_version(18);

  UsbCameraSettings settings;
  settings.imu = true;
  Bench bench(settings);
  const Status started = bench.source.start();
  char text[300];
  started.describe(text);
  std::printf("       start: %s\n", text);
  expect(started.ok(), "the source starts");
  if (!started.ok()) return 1;
  expect(bench.until_event(10'000'000) >= 0, "the first event comes");
  check_stream(bench, camera);

  expect(survey_one().code() == StatusCode::kDeviceBusy, "meanwhile others find it claimed");
  {
    Bench second(settings);
    expect(second.source.start().code() == StatusCode::kDeviceBusy, "a second source is refused");
  }

  camera.set_dropped(0x100000007);
  for (std::int64_t begin_us = now_us(); now_us() - begin_us < 1'500'000;) {
    bench.poll();
    bench.drop_events();
  }
  expect(bench.source.counters().device_dropped == 0x100000007, "what the camera dropped is read");

  camera.stall();
  bench.drop_events();
  const std::int64_t stalled_us = bench.until_event(5'000'000);
  std::printf("       after a stall: %" PRId64 " us, %" PRIu64 " stalls, %" PRIu64 " lost\n", stalled_us,
              bench.source.counters().stalls, bench.source.counters().lost);
  expect(stalled_us >= 0 && bench.source.counters().stalls >= 1 && bench.source.counters().lost == 0,
         "a stall is cleared and the stream goes on");
  check_stream(bench, camera);

  camera.hold(true);
  for (std::int64_t begin_us = now_us(); now_us() - begin_us < 1'500'000;) bench.poll();
  expect(bench.source.counters().lost == 1, "silence is a loss");
  camera.hold(false);
  bench.drop_events();
  expect(bench.until_event(10'000'000) >= 0, "and the camera is started again");

  check_reopening(bench, camera);
  check_stream(bench, camera);
  std::printf("       longest poll of all %" PRId64 " us\n", bench.longest_poll_us);
  const std::int64_t stop_us = now_us();
  bench.source.stop();
  std::printf("       stop took %" PRId64 " us\n", now_us() - stop_us);
  expect(now_us() - stop_us < 200'000, "a stop takes less than 0.2 s");
  camera.unplug();
  std::printf("%d failures\n", failures);
  return failures == 0 ? 0 : 1;
}
