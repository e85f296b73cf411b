// What a camera, its cable and its clock can do.
#include <array>

#include "trial.hpp"

namespace egofocus::reliability {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;

Row unplugged() {
  Robot robot;
  Trial trial("camera unplugged and back, 20 times", "ENODEV in all transfers; away for 0.2 s to 2.1 s",
              robot);
  std::int64_t longest_us = 0;
  for (int i = 0; i < 20; ++i) {
    robot.camera().is_plugged = false;
    robot.run((2 + i) * kSecond_us / 10);
    robot.camera().is_plugged = true;
    const std::int64_t back_us = robot.now_us();
    while (robot.phase() != UsbCameraPhase::kStreaming && robot.now_us() - back_us < 5 * kSecond_us)
      robot.run(Robot::kStep_us);
    longest_us = std::max(longest_us, robot.now_us() - back_us);
    robot.run(kSecond_us);
  }
  trial.over();
  trial.expect(trial.up("camera_lost") == 20 && trial.up("camera_opened") == 20,
               "not 20 losses, 20 times opened");
  trial.remark("streams again at most " + recording::number_text(static_cast<double>(longest_us) * 1e-6) +
               " s after it is back");
  return trial.row();
}

Row unplugged_during_start() {
  Robot robot;
  Trial trial("camera unplugged while it starts, 20 times", "ENODEV between two steps of its start sequence",
              robot);
  for (int i = 0; i < 20; ++i) {
    robot.camera().is_plugged = false;
    robot.run(kSecond_us / 5);
    robot.camera().is_plugged = true;
    for (int k = 0; robot.phase() != UsbCameraPhase::kStarting && k < 1'000; ++k) robot.run(Robot::kStep_us);
    robot.run(i * Robot::kStep_us);
  }
  trial.over();
  trial.expect(trial.up("camera_lost") >= 20, "not each was seen as a loss");
  return trial.row();
}

Row stalls() {
  Robot robot;
  Trial trial("endpoint stalls", "EPIPE at the end of 5 % of the transfers, 5 s", robot);
  robot.trouble.stalled_transfers = 0.05;
  robot.run(5 * kSecond_us);
  robot.trouble = {};
  trial.over();
  trial.expect(trial.up("camera_stalls") > 10, "too few stalls");
  return trial.row();
}

Row silence() {
  Robot robot;
  Trial trial("camera falls silent", "no transfer ends for 3 s", robot);
  robot.trouble.camera_silent = true;
  robot.run(3 * kSecond_us);
  robot.trouble = {};
  trial.over();
  trial.expect(trial.up("camera_lost") >= 1, "the silence was not noticed");
  return trial.row();
}

Row damaged() {
  Robot robot;
  Trial trial("short and corrupt packets",
              "2 % of the words random, 5 % of the transfers cut within a word, 2 % lost to an overflow, 5 s",
              robot);
  robot.trouble.corrupt_words = 0.02;
  robot.trouble.short_transfers = 0.05;
  robot.trouble.overflown_transfers = 0.02;
  robot.run(5 * kSecond_us);
  robot.trouble = {};
  robot.reset_camera_clock();
  trial.over();
  trial.expect(trial.up("camera_stream_violations") > 0 && trial.up("camera_overflows") > 0,
               "nothing was noticed");
  return trial.row();
}

Row clock_leaps(std::int64_t leap_us, const char* fault) {
  Robot robot;
  Trial trial(fault,
              "the camera's time leaps by " + std::to_string(leap_us / kSecond_us) + " s without a word",
              robot);
  robot.leap_camera_clock(leap_us);
  robot.run(kSecond_us);
  trial.over();
  return trial.row();
}

Row clock_resets() {
  Robot robot;
  Trial trial("camera's clock is reset", "the mark TIMESTAMP_RESET, three times", robot);
  for (int i = 0; i < 3; ++i) {
    robot.reset_camera_clock();
    robot.run(kSecond_us);
  }
  trial.over();
  trial.expect(trial.up("camera_clock_restarts") == 3, "not three restarts");
  return trial.row();
}

Row wraps() {
  Robot robot;
  Trial trial("time stamps wrap", "15-bit device time: 30 wraps a second, 70 s", robot);
  robot.run(70 * kSecond_us);
  trial.over();
  const Seen seen = trial.seen();
  trial.expect(seen.good == seen.ticks && seen.ticks >= 1'399, "a wrap was seen in the depth");
  return trial.row();
}

Row drift() {
  Robot robot;
  Trial trial("clock drift", "50 ppm, and up to 5 ms of jitter in each transfer, 60 s", robot);
  robot.trouble.drift_ppm = 50;
  robot.trouble.jitter_us = 5'000;
  robot.run(10 * kSecond_us);
  static_cast<void>(trial.seen());
  const Seen settled = robot.look();
  robot.run(50 * kSecond_us);
  const Seen seen = robot.look();
  trial.expect(seen.clock_error_us <= 300 && settled.ticks == 0,
               "the time is off by " + std::to_string(seen.clock_error_us) + " us");
  trial.remark("after 10 s an event's time is at most " + std::to_string(seen.clock_error_us) + " us off");
  robot.trouble = {};
  trial.over();
  return trial.row();
}

Row second_user() {
  Robot robot;
  const UsbCameraSettings settings;
  std::vector<std::byte> buffers(UsbCameraSource::buffer_bytes(settings));
  Trial trial("second daemon on the same camera", "the claim of the interface says EBUSY", robot);
  robot.camera().claim_error = EBUSY;
  const UsbIo io = robot.bus.io();
  UsbCameraSource second(settings, buffers, io, robot.bus.clock.clock());
  const Status refused = second.open();
  robot.camera().claim_error = 0;
  trial.expect(refused.code() == StatusCode::kDeviceBusy, "the second one was not refused");
  robot.run(2 * kSecond_us);
  trial.over();
  const Seen seen = trial.seen();
  trial.expect(seen.good == seen.ticks, "the first one noticed");
  std::array<char, 300> text{};
  refused.describe(text);
  trial.remark(std::string("the second says: ") + text.data());
  return trial.row();
}

}  // namespace

std::vector<Fault> camera_faults() {
  return {{"camera_unplugged", unplugged},
          {"camera_unplugged_during_start", unplugged_during_start},
          {"camera_stalls", stalls},
          {"camera_silent", silence},
          {"camera_damaged", damaged},
          {"camera_clock_ahead", [] { return clock_leaps(10 * kSecond_us, "time stamps jump ahead"); }},
          {"camera_clock_back", [] { return clock_leaps(-5 * kSecond_us, "time stamps jump back"); }},
          {"camera_clock_reset", clock_resets},
          {"camera_clock_wraps", wraps},
          {"camera_clock_drift", drift},
          {"camera_second_user", second_user}};
}

}  // namespace egofocus::reliability
