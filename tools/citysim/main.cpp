// citysim: the command line of the simulator.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <thread>

#include "citysim/recording_writer.hpp"
#include "citysim/world.hpp"
#include "egofocus/version.hpp"
#include "recording/error.hpp"
#include "recording/json.hpp"
#include "recording/progress.hpp"

namespace egofocus::citysim {
namespace {

using recording::Error;
using recording::ExitCode;

struct Arguments {
  std::string family;
  std::string out;
  std::string size = "346x260";
  int frames = 1500;
  std::uint64_t seed = 1;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool clean = false;
  bool no_pictures = false;
  bool json = false;
};

std::string about_families() {
  std::string text = "Families:\n";
  for (const FamilyName& family : families()) {
    char line[120];
    std::snprintf(line, sizeof line, "  %-12s %s\n", std::string(family.name).c_str(),
                  std::string(family.about).c_str());
    text += line;
  }
  return text;
}

constexpr const char* kExamples = R"(
Examples:
  citysim town5_night --frames 1500 --out out/town5 --seed 1    75 s of driving by night
  citysim room --frames 40 --out out/room --seed 7 --clean      2 s with an ideal sensor
  citysim desk --size 240x180 --out out/desk                    another camera

An interrupted run goes on where it was when the same command is given again.
Exit codes: 0 ok, 1 internal error, 2 wrong command line, 3 a file cannot be written.)";

Family parse_family(const std::string& name) {
  const std::optional<Family> family = family_of(name);
  if (family) return *family;
  std::string known;
  for (const FamilyName& each : families()) known += (known.empty() ? "" : ", ") + std::string(each.name);
  throw Error(ExitCode::kUsage, "'" + name + "'", "is no family. There are: " + known + ".");
}

void run(const Arguments& arguments) {
  RecordingOptions options;
  options.family = parse_family(arguments.family);
  options.frames = arguments.frames;
  options.seed = arguments.seed;
  options.clean_sensor = arguments.clean;
  options.pictures = !arguments.no_pictures;
  options.threads = arguments.threads;
  int used = 0;
  if (std::sscanf(arguments.size.c_str(), "%4dx%4d%n", &options.width_px, &options.height_px, &used) != 2 ||
      static_cast<std::size_t>(used) != arguments.size.size() || options.width_px < 64 ||
      options.width_px > 1280 || options.height_px < 64 || options.height_px > 1280) {
    throw Error(ExitCode::kUsage, "--size", "must look like 346x260, each side within 64..1280.");
  }
  recording::Progress progress(arguments.family);
  options.progress = [&progress](int done, int all) {
    progress.show(static_cast<std::size_t>(done), static_cast<std::size_t>(all));
  };
  const RecordingReport report = write_recording(options, arguments.out);
  recording::Json facts;
  facts.add("recording", arguments.out)
      .add("seconds", report.seconds)
      .add("events", report.events)
      .add("views", report.views)
      .add("wide_steps_share", report.wide_steps_share)
      .add("resumed_at_frame", report.resumed_at);
  std::puts((arguments.json ? facts.json() : facts.text()).c_str());
}

}  // namespace
}  // namespace egofocus::citysim

int main(int argc, char** argv) {
  using egofocus::recording::Error;
  using egofocus::recording::ExitCode;
  egofocus::citysim::Arguments arguments;
  CLI::App program("Synthetic recordings of one event camera on a moving robot, with exact depth.",
                   "citysim");
  program.set_version_flag("--version", "citysim " EGOFOCUS_VERSION);
  program.footer(egofocus::citysim::about_families() + egofocus::citysim::kExamples);
  program.add_option("family", arguments.family, "what to film; see below")->required();
  program.add_option("--out", arguments.out, "folder of the new recording")->required();
  program.add_option("--frames", arguments.frames, "depth pictures, 20 a second")
      ->check(CLI::Range(1, 19000))
      ->capture_default_str();
  program.add_option("--seed", arguments.seed, "everything is drawn from it")->capture_default_str();
  program.add_option("--size", arguments.size, "the sensor's pixels")->capture_default_str();
  program.add_option("--threads", arguments.threads, "the bytes do not depend on it")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  program.add_flag("--clean", arguments.clean, "a sensor without faults");
  program.add_flag("--no-pictures", arguments.no_pictures, "depth only, no grey and RGB pictures");
  program.add_flag("--json", arguments.json, "print facts as JSON");
  try {
    program.parse(argc, argv);
    egofocus::citysim::run(arguments);
    return static_cast<int>(ExitCode::kOk);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? static_cast<int>(ExitCode::kOk) : static_cast<int>(ExitCode::kUsage);
  } catch (const Error& error) {
    std::fprintf(stderr, "citysim: %s\n", error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "citysim: internal error: %s\n", error.what());
    return static_cast<int>(ExitCode::kInternal);
  }
}
