#include "recording/convert.hpp"

#include <memory>
#include <string>

#include "commands.hpp"
#include "core/decimal.hpp"
#include "recording/error.hpp"
#include "recording/json.hpp"
#include "recording/progress.hpp"

namespace egofocus::app {

using recording::Json;
using recording::Progress;

namespace {

struct Arguments {
  std::string input;
  std::string output;
  std::string format;
  std::string size;
  std::string t0;
  std::string kalibr;
  std::string poses;
  std::string camera = "left";
  double z_near_m = 0.5;
  bool json = false;
};

SensorSize parse_size(const std::string& text) {
  int width = 0;
  int height = 0;
  int used = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%n", &width, &height, &used) != 2 ||
      static_cast<std::size_t>(used) != text.size() || width < 1 || height < 1 || width > 65535 ||
      height > 65535) {
    throw recording::Error(recording::ExitCode::kUsage, "--size", "must look like 240x180.");
  }
  return {static_cast<std::uint16_t>(width), static_cast<std::uint16_t>(height)};
}

std::int64_t parse_t0(const std::string& text) {
  Decimal seconds;
  std::int64_t t_us = 0;
  if (scan_decimal(text, seconds) != text.size() || !to_microseconds(seconds, t_us)) {
    throw recording::Error(recording::ExitCode::kUsage, "--t0",
                           "must be a number of seconds, such as 1436509052.25.");
  }
  return t_us;
}

std::string list_text(const std::vector<std::string>& entries, const char* between) {
  std::string text;
  for (const std::string& entry : entries) text += (text.empty() ? "" : between) + entry;
  return text;
}

Json facts_of(const recording::ConvertReport& report, const std::string& output) {
  Json dropped;
  dropped.add("malformed", report.malformed)
      .add("out_of_order", report.out_of_order)
      .add("out_of_range", report.out_of_range)
      .add("before_t0", report.before_t0);
  Json facts;
  facts.add("recording", output)
      .add("width_px", report.size.width_px)
      .add("height_px", report.size.height_px)
      .add("t0_us", report.t0_us)
      .add("events", report.events)
      .add("first_us", report.first_us)
      .add("last_us", report.last_us)
      .add("poses", report.poses)
      .add("poses_dropped", report.poses_dropped)
      .add("widest_pose_gap_us", report.widest_pose_gap_us)
      .add("events_before_poses", report.events_before_poses)
      .add("events_after_poses", report.events_after_poses)
      .add("imu_samples", report.imu_samples)
      .add("imu_dropped", report.imu_dropped)
      .add("depth_pictures", report.depth_pictures)
      .add("depth_dropped", report.depth_dropped)
      .add("depth_out_of_scale", report.depth_out_of_scale)
      .add("dropped_events", dropped)
      .add("files_left_out", list_text(report.left_out, ", "))
      .add("remarks", list_text(report.remarks, " "));
  return facts;
}

void run(const Arguments& arguments) {
  recording::ConvertOptions options;
  if (!arguments.size.empty()) options.size = parse_size(arguments.size);
  if (!arguments.t0.empty()) options.t0_us = parse_t0(arguments.t0);
  options.z_near_m = arguments.z_near_m;
  options.kalibr = arguments.kalibr;
  options.poses = arguments.poses;
  options.camera = arguments.camera == "right" ? recording::CameraSide::kRight : recording::CameraSide::kLeft;
  const recording::InputFormat format = arguments.format.empty()
                                            ? recording::guess_format(arguments.input)
                                            : *recording::input_format_of(arguments.format);
  recording::ConvertReport report;
  {
    Progress progress("converting");
    options.progress = [&progress](std::size_t done, std::size_t all) { progress.show(done, all); };
    report = recording::convert(format, arguments.input, arguments.output, options);
  }
  const Json facts = facts_of(report, arguments.output);
  std::puts((arguments.json ? facts.json() : facts.text()).c_str());
}

}  // namespace

void add_convert(CLI::App& program) {
  CLI::App* command = program.add_subcommand("convert", "make a recording folder from another layout");
  auto arguments = std::make_shared<Arguments>();
  command
      ->add_option("INPUT", arguments->input, "ECD folder, MVSEC *_data.hdf5, DSEC sequence or AEDAT4 file")
      ->required();
  command->add_option("OUTPUT_DIR", arguments->output, "recording folder to make")->required();
  command->add_option("--format", arguments->format, "layout of the input (default: guessed from it)")
      ->check(CLI::IsMember({"ecd", "mvsec", "dsec", "aedat4"}));
  command->add_option("--kalibr", arguments->kalibr,
                      "calibration, a Kalibr camchain (MVSEC: default is the one beside the data)");
  command->add_option("--poses", arguments->poses,
                      "poses of the event camera, t px py pz qx qy qz qw, on the input's clock");
  command->add_option("--camera", arguments->camera, "of a stereo pair (MVSEC, AEDAT4)")
      ->check(CLI::IsMember({"left", "right"}))
      ->capture_default_str();
  command->add_option("--size", arguments->size,
                      "sensor, such as 240x180 (default: from calibration and events)");
  command->add_option("--t0", arguments->t0,
                      "seconds to subtract from all times (default: 0, or an epoch's whole seconds)");
  command->add_option("--z-near", arguments->z_near_m, "nearest depth in metres, for camera.toml")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "report as JSON");
  command->footer(
      "Examples:\n"
      "  egofocus convert slider_depth out/slider --size 240x180\n"
      "  egofocus convert indoor_flying1_data.hdf5 out/flying --kalibr camchain-imucam-indoor_flying.yaml\n"
      "  egofocus convert zurich_city_00_a out/zurich --poses zurich_city_00_a/poses.txt --z-near 3\n"
      "  egofocus convert dvSave.aedat4 out/desk --kalibr camchain.yaml --poses poses.txt\n"
      "docs/formats.md says what each layout must hold and what becomes of it.");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace egofocus::app
