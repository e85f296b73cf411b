// egofocusd: depth for other processes, from a camera and a bus, for days. This file is its whole life.
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>
#include <system_error>

#include "control_server.hpp"
#include "daemon_config.hpp"
#include "egofocus/version.hpp"
#include "find_problems.hpp"
#include "log.hpp"
#include "recording/error.hpp"
#include "recording/text_file.hpp"
#include "service.hpp"
#include "signals.hpp"

namespace {

using namespace egofocus::daemon;
using egofocus::recording::Error;
using egofocus::recording::ExitCode;

constexpr const char* kDefaultConfig = "/etc/egofocus/egofocusd.toml";
constexpr const char* kFooter = R"(Examples:
  egofocusd --print-config > egofocusd.toml         a commented configuration to begin with
  egofocusd --config egofocusd.toml --check-config  all that is wrong, before anything starts
  egofocusd --config egofocusd.toml                 run in the foreground; systemd does the same
  egofocusd --config egofocusd.toml --ask health    also: "record start", "record stop", reload

Signals: SIGTERM stops, SIGHUP reads the configuration and the model again.
Exit codes: 0 ok, 1 internal error, 2 wrong command line, 3 file or device missing, 4 bad file, 5 bad configuration,
6 no motion, 7 no events, 8 another daemon has the sockets, 9 no memory.)";

int check(const std::string& file) {
  DaemonConfig config;
  const Problems problems = find_problems(file, config);
  for (const std::string& line : problems.errors) std::fprintf(stderr, "egofocusd: %s\n", line.c_str());
  for (const std::string& line : problems.warnings)
    std::fprintf(stderr, "egofocusd: warning: %s\n", line.c_str());
  if (!problems.errors.empty()) return static_cast<int>(ExitCode::kConfiguration);
  std::printf("%s: sound\n", file.c_str());
  return static_cast<int>(ExitCode::kOk);
}

int serve(const std::string& file) {
  const Signals signals;  // before any thread
  Service service(read_daemon_config(file));
  return service.run(signals);
}

int tell_daemon(const std::string& file, const std::string& request) {
  const std::string answer = ask(read_daemon_config(file).control.socket, request);
  std::puts(answer.c_str());
  return static_cast<int>(answer.starts_with("{\"error\"") ? ExitCode::kUsage : ExitCode::kOk);
}

int complain(const char* what, ExitCode code) {
  std::fprintf(stderr, "egofocusd: %s\n", what);
  return static_cast<int>(code);
}

}  // namespace

int main(int argc, char** argv) {
  ::mallopt(M_MMAP_THRESHOLD, 128 * 1024);  // fixed: what a reload frees goes back to the system
  CLI::App program("Depth from an event camera and measured motion, as a service.", "egofocusd");
  std::string file = kDefaultConfig;
  std::string request;
  program.set_version_flag("--version", "egofocusd " EGOFOCUS_VERSION);
  program.add_option("--config", file, "the configuration file")->capture_default_str();
  bool print = false;
  bool only_check = false;
  program.add_flag("--print-config", print, "print the commented default configuration");
  program.add_flag("--check-config", only_check, "find all that is wrong, start nothing");
  program.add_option("--ask", request, "ask the running daemon: health, \"record start\", ...");
  program.footer(kFooter);
  try {
    program.parse(argc, argv);
    int code = 0;
    if (print) {
      std::fputs(default_config_text(), stdout);
    } else if (only_check) {
      code = check(file);
    } else if (!request.empty()) {
      code = tell_daemon(file, request);
    } else {
      code = serve(file);
    }
    egofocus::recording::flush_standard_output();
    return code;
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  } catch (const Error& error) {
    return complain(error.what(), static_cast<ExitCode>(error.exit_code()));
  } catch (const std::bad_alloc&) {
    return complain("no memory", ExitCode::kMemory);
  } catch (const std::filesystem::filesystem_error& error) {
    return complain(egofocus::recording::refused(error).what(), ExitCode::kFile);
  } catch (const std::system_error& error) {  // nothing else throws it here
    return complain((std::string("no memory for a thread: ") + error.what()).c_str(), ExitCode::kMemory);
  } catch (const std::exception& error) {
    return complain((std::string("internal error: ") + error.what()).c_str(), ExitCode::kInternal);
  }
}
