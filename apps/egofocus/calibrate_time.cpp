#include <cstdio>
#include <memory>
#include <string>

#include "commands.hpp"
#include "recording/error.hpp"
#include "recording/folder.hpp"
#include "recording/json.hpp"
#include "recording/time_offset.hpp"

namespace egofocus::app {
namespace {

using recording::Error;
using recording::ExitCode;

struct Arguments {
  std::string recording;
  double range_ms = 60;
  bool json = false;
};

void run(const Arguments& arguments) {
  const recording::Folder folder = recording::open_folder(arguments.recording, MotionSource::kOdometry);
  const recording::TimeOffset found = recording::estimate_time_offset(folder, arguments.range_ms);
  recording::Json facts;
  facts.add("imu_delay_us", found.imu_delay_us)
      .add("imu_delay_us_now", found.old_imu_delay_us)
      .add("late_ms", found.late_ms)
      .add("sigma_ms", found.sigma_ms)
      .add("correlation", found.correlation)
      .add("rotation_rad_s", found.rotation_rad_s)
      .add("windows", found.windows)
      .add("trusted", found.doubt.empty());
  std::puts((arguments.json ? facts.json() : facts.text()).c_str());
  if (!found.doubt.empty())
    throw Error(ExitCode::kMotion, arguments.recording, "no offset to be trusted: " + found.doubt + ".");
}

}  // namespace

void add_calibrate_time(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("calibrate-time", "by how much the IMU comes later than the events");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("RECORDING", arguments->recording, "recording with events and a gyro on CAN")
      ->required();
  command->add_option("--range-ms", arguments->range_ms, "offsets to look at, either way")
      ->check(CLI::Range(5.0, 200.0))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "one line of JSON");
  command->footer(
      "Turns of the camera, seen by its events, are compared with those of the gyro. Record about 10 s in "
      "which the\n"
      "camera is turned to and fro, then write imu_delay_us into [can] of camera.toml. The rest of the "
      "delay, that of\n"
      "the camera itself, is in it as well.\n"
      "Example:\n  egofocus calibrate-time fixtures/town5_night");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace egofocus::app
