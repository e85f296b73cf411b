// The real source, over the real libusb and kernel, against an emulated DAVIS346. Prints what was measured.
#include <dirent.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "hil/emulated_davis.hpp"
#include "hil/usb_bench.hpp"

using namespace egofocus;
using namespace egofocus::hil;

namespace {

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

void check_imu(Bench& bench) {
  const std::span<const ImuSample> samples = bench.rings.imu.peek(1 << 12);
  std::printf("       %zu IMU samples\n", samples.size());
  expect(samples.size() > 100, "IMU samples come");
  expect(!samples.empty() && samples[0].accel_m_s2[0] > 9.8 && samples[0].accel_m_s2[0] < 9.82,
         "and are in SI");
  bench.rings.imu.release(samples.size());
}

// The kernel needs a moment to give the port free.
bool plugged_again(Bench& bench, EmulatedDavis& camera) {
  for (int i = 0; i < 200; ++i) {
    if (camera.plug()) return true;
    bench.poll();
  }
  return false;
}

void check_reopening(Bench& bench, EmulatedDavis& camera) {
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
  CountedEvents feed(kRate_hz, EmulatedDavis::kWidth_px, EmulatedDavis::kHeight_px);
  EmulatedDavis camera(feed);
  expect(camera.plug(), "the kernel takes the camera");
  std::int64_t waited_us = host_us();
  while (survey_one().code() == StatusCode::kNoDevice && host_us() - waited_us < 10'000'000) usleep(100'000);
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
  check_stream(bench, EmulatedDavis::kWidth_px, EmulatedDavis::kHeight_px);
  check_imu(bench);

  expect(survey_one().code() == StatusCode::kDeviceBusy, "meanwhile others find it claimed");
  {
    Bench second(settings);
    expect(second.source.start().code() == StatusCode::kDeviceBusy, "a second source is refused");
  }

  camera.set_dropped(0x100000007);
  for (std::int64_t begin_us = host_us(); host_us() - begin_us < 1'500'000;) {
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
  check_stream(bench, EmulatedDavis::kWidth_px, EmulatedDavis::kHeight_px);

  camera.hold(true);
  for (std::int64_t begin_us = host_us(); host_us() - begin_us < 1'500'000;) bench.poll();
  expect(bench.source.counters().lost == 1, "silence is a loss");
  camera.hold(false);
  bench.drop_events();
  expect(bench.until_event(10'000'000) >= 0, "and the camera is started again");

  check_reopening(bench, camera);
  check_stream(bench, EmulatedDavis::kWidth_px, EmulatedDavis::kHeight_px);
  std::printf("       longest poll of all %" PRId64 " us\n", bench.longest_poll_us);
  const std::int64_t stop_us = host_us();
  bench.source.stop();
  std::printf("       stop took %" PRId64 " us\n", host_us() - stop_us);
  expect(host_us() - stop_us < 200'000, "a stop takes less than 0.2 s");
  camera.unplug();
  std::printf("%d failures\n", failures);
  return failures == 0 ? 0 : 1;
}
