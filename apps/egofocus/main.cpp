// egofocus: the command line. One file per subcommand; commands.hpp lists them.
#include <cstdio>
#include <exception>

#include "commands.hpp"
#include "egofocus/version.hpp"
#include "recording/error.hpp"
#include "recording/text_file.hpp"

namespace {

constexpr const char* kExamples = R"(Examples:
  egofocus replay fixtures/planes --out out/planes     depth of a recording, with pictures
  egofocus eval fixtures/planes --cut 10               the same against its truth: all metrics
  egofocus info fixtures/planes                        what is in a recording
  egofocus info events.raw --json                      the same of one file, for programs
  egofocus overlay town1 --out out/overlay             do its frames, depth and events lie on each other?
  egofocus convert slider_depth out/slider             a recording from ECD, MVSEC, DSEC or AEDAT4 files
  egofocus devices                                     event cameras on USB: which can be used, and why others cannot

Exit codes: 0 ok, 1 internal error, 2 wrong command line, 3 file missing or unreadable, 4 bad or truncated file,
5 bad configuration, 6 no motion or a gap in it, 7 no events, 10 no device, 11 no device that can be used.)";

}  // namespace

int main(int argc, char** argv) {
  using egofocus::recording::Error;
  using egofocus::recording::ExitCode;
  CLI::App program("Metric depth from one event camera and measured motion.", "egofocus");
  program.set_version_flag("--version", "egofocus " EGOFOCUS_VERSION);
  program.require_subcommand(1);
  program.footer(kExamples);
  egofocus::app::add_convert(program);
  egofocus::app::add_devices(program);
  egofocus::app::add_eval(program);
  egofocus::app::add_info(program);
  egofocus::app::add_overlay(program);
  egofocus::app::add_replay(program);
  const auto complain = [](const Error& error) {
    std::fprintf(stderr, "egofocus: %s\n", error.what());
    return error.exit_code();
  };
  try {
    ExitCode code = ExitCode::kOk;
    try {
      program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      // --help and --version come this way, too, with code 0.
      if (program.exit(error) != 0) code = ExitCode::kUsage;
    }
    egofocus::recording::flush_standard_output();
    return static_cast<int>(code);
  } catch (const Error& error) {
    return complain(error);
  } catch (const std::filesystem::filesystem_error& error) {
    return complain(egofocus::recording::refused(error));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "egofocus: internal error: %s\n", error.what());
    return static_cast<int>(ExitCode::kInternal);
  }
}
