#include <memory>
#include <string>

#include "commands.hpp"
#include "core/decimal.hpp"
#include "json.hpp"
#include "progress.hpp"
#include "recording/convert_ecd.hpp"
#include "recording/error.hpp"

namespace egofocus::app {
namespace {

struct Arguments {
  std::string input;
  std::string output;
  std::string format = "ecd";
  std::string size;
  std::string t0;
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

void run(const Arguments& arguments) {
  Progress progress("reading events");
  recording::EcdOptions options;
  if (!arguments.size.empty()) options.size = parse_size(arguments.size);
  if (!arguments.t0.empty()) options.t0_us = parse_t0(arguments.t0);
  options.z_near_m = arguments.z_near_m;
  options.progress = [&progress](std::size_t done, std::size_t all) { progress.show(done, all); };
  const recording::EcdReport report = recording::convert_ecd(arguments.input, arguments.output, options);

  std::string left_out;
  for (const std::string& name : report.left_out) left_out += (left_out.empty() ? "" : ", ") + name;
  Json dropped;
  dropped.add("malformed", report.malformed)
      .add("out_of_order", report.out_of_order)
      .add("out_of_range", report.out_of_range)
      .add("before_t0", report.before_t0);
  Json facts;
  facts.add("recording", arguments.output)
      .add("width_px", report.size.width_px)
      .add("height_px", report.size.height_px)
      .add("t0_us", report.t0_us)
      .add("events", report.events)
      .add("first_us", report.first_us)
      .add("last_us", report.last_us)
      .add("poses", report.poses)
      .add("events_before_poses", report.events_before_poses)
      .add("events_after_poses", report.events_after_poses)
      .add("dropped_events", dropped)
      .add("files_left_out", left_out);
  std::puts((arguments.json ? facts.json() : facts.text()).c_str());
}

}  // namespace

void add_convert(CLI::App& program) {
  CLI::App* command = program.add_subcommand("convert", "make a recording folder from a text set");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("INPUT_DIR", arguments->input, "folder with events.txt, calib.txt, groundtruth.txt")
      ->required();
  command->add_option("OUTPUT_DIR", arguments->output, "recording folder to make")->required();
  command->add_option("--format", arguments->format, "layout of the input")
      ->check(CLI::IsMember({"ecd"}))
      ->capture_default_str();
  command->add_option("--size", arguments->size,
                      "sensor, such as 240x180 (default: from calibration and events)");
  command->add_option("--t0", arguments->t0,
                      "seconds to subtract from all times (default: 0, or an epoch's whole seconds)");
  command->add_option("--z-near", arguments->z_near_m, "nearest depth in metres, for camera.toml")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "report as JSON");
  command->footer("Example: egofocus convert slider_depth out/slider --size 240x180");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace egofocus::app
