#include <cstdio>
#include <thread>

#include "citysim/command_line.hpp"
#include "citysim/commands.hpp"
#include "citysim/recording_writer.hpp"
#include "recording/json.hpp"
#include "recording/progress.hpp"

namespace egofocus::citysim {
namespace {

constexpr const char* kExamples = R"(
Examples:
  citysim town5_night --frames 1500 --out out/town5 --seed 1    75 s of driving by night
  citysim room --frames 40 --out out/room --seed 7 --clean      2 s with an ideal sensor
  citysim desk --size 240x180 --out out/desk                    another camera

An interrupted run goes on where it was when the same command is given again.
Exit codes: 0 ok, 1 internal error, 2 wrong command line, 3 a file cannot be written.)";

}  // namespace

int run_record(std::span<const std::string> arguments) {
  std::string family;
  std::string out;
  std::string size = "346x260";
  bool no_pictures = false;
  bool json = false;
  RecordingOptions options;
  options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  CLI::App program("A whole recording: events, motion on a CAN bus, exact depth, pictures.", "citysim");
  program.footer(about_families() + kExamples);
  program.add_option("family", family, "what to film; see below")->required();
  program.add_option("--out", out, "folder of the new recording")->required();
  program.add_option("--frames", options.frames, "depth pictures, 20 a second")
      ->check(CLI::Range(1, 19000))
      ->capture_default_str();
  program.add_option("--seed", options.seed, "everything is drawn from it")->capture_default_str();
  program.add_option("--size", size, "the sensor's pixels")->capture_default_str();
  program.add_option("--threads", options.threads, "the bytes do not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  program.add_flag("--clean", options.clean_sensor, "a sensor without faults");
  program.add_flag("--no-pictures", no_pictures, "depth only, no grey and RGB pictures");
  program.add_flag("--json", json, "print facts as JSON");
  int code = 0;
  if (!parse(program, arguments, code)) return code;

  options.family = parse_family(family);
  options.pictures = !no_pictures;
  parse_size(size, options.width_px, options.height_px);
  recording::Progress progress(family);
  options.progress = [&progress](int done, int all) {
    progress.show(static_cast<std::size_t>(done), static_cast<std::size_t>(all));
  };
  const RecordingReport report = write_recording(options, out);
  recording::Json facts;
  facts.add("recording", out)
      .add("seconds", report.seconds)
      .add("events", report.events)
      .add("views", report.views)
      .add("wide_steps_share", report.wide_steps_share)
      .add("resumed_at_frame", report.resumed_at);
  std::puts((json ? facts.json() : facts.text()).c_str());
  return static_cast<int>(recording::ExitCode::kOk);
}

}  // namespace egofocus::citysim
