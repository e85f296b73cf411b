// citysim: the command line of the simulator.
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "citysim/commands.hpp"
#include "citysim/realism.hpp"
#include "egofocus/version.hpp"
#include "recording/error.hpp"
#include "recording/text_file.hpp"

namespace {

constexpr const char* kHelp =
    R"(citysim: synthetic recordings of one event camera on a moving robot, with exact depth

  citysim FAMILY --out DIR    a whole recording                    citysim town1 --help
  citysim samples             training samples, as a stream        citysim samples --help
  citysim stats               what the families' scenes are like   citysim stats --help
  citysim realism             events beside those of real sensors  citysim realism --help
  citysim --version

)";

int run(std::vector<std::string> arguments) {
  using namespace egofocus::citysim;
  if (arguments.empty() || arguments[0] == "--help" || arguments[0] == "-h") {
    std::fputs((kHelp + about_families()).c_str(), arguments.empty() ? stderr : stdout);
    return arguments.empty() ? static_cast<int>(egofocus::recording::ExitCode::kUsage) : 0;
  }
  if (arguments[0] == "--version") {
    std::puts("citysim " EGOFOCUS_VERSION);
    return 0;
  }
  const std::span<const std::string> rest = std::span(arguments).subspan(1);
  if (arguments[0] == "samples") return run_samples(rest);
  if (arguments[0] == "stats") return run_stats(rest);
  if (arguments[0] == "realism") return run_realism(rest);
  return run_record(arguments);
}

}  // namespace

int main(int argc, char** argv) {
  using egofocus::recording::Error;
  using egofocus::recording::ExitCode;
  const auto complain = [](const Error& error) {
    std::fprintf(stderr, "citysim: %s\n", error.what());
    return error.exit_code();
  };
  try {
    const int code = run(std::vector<std::string>(argv + 1, argv + argc));
    egofocus::recording::flush_standard_output();
    return code;
  } catch (const Error& error) {
    return complain(error);
  } catch (const std::filesystem::filesystem_error& error) {
    return complain(egofocus::recording::refused(error));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "citysim: internal error: %s\n", error.what());
    return static_cast<int>(ExitCode::kInternal);
  }
}
