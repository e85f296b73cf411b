#include "find_problems.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include "open_source.hpp"
#include "recording/error.hpp"
#include "recording/text_file.hpp"
#include "setup.hpp"
#include "unix_socket.hpp"

namespace egofocus::daemon {
namespace {

namespace fs = std::filesystem;

void check_folder(const std::string& key, const fs::path& folder, Problems& problems) {
  const std::string name = (folder.empty() ? fs::path(".") : folder).string();
  std::error_code ignored;
  if (!fs::is_directory(name, ignored)) {
    problems.errors.push_back(
        key + ": " + name +
        " is no folder. Make it, or let systemd make it (RuntimeDirectory=, StateDirectory=).");
  } else if (::access(name.c_str(), W_OK | X_OK) != 0) {
    problems.errors.push_back(key + ": " + name +
                              " cannot be written by this user. Change its owner or permissions.");
  }
}

rlim_t limit_of(int resource) {
  rlimit limit{};
  return ::getrlimit(static_cast<__rlimit_resource>(resource), &limit) == 0 ? limit.rlim_cur : RLIM_INFINITY;
}

void check_limits(const DaemonConfig& config, std::size_t arena_bytes, Problems& problems) {
  if (::geteuid() == 0) return;
  const RealTimeConfig& wished = config.engine.real_time;
  if (wished.fifo_priority > 0 && limit_of(RLIMIT_RTPRIO) < static_cast<rlim_t>(wished.fifo_priority)) {
    problems.warnings.push_back(
        "[engine] fifo_priority: this user's rtprio limit is lower. LimitRTPRIO= in the unit, or "
        "limits.conf.");
  }
  if (wished.lock_memory && limit_of(RLIMIT_MEMLOCK) < 2 * arena_bytes) {
    problems.warnings.push_back(
        "[engine] lock_memory: this user's memlock limit is too low. LimitMEMLOCK=infinity in the unit, or "
        "limits.conf.");
  }
}

}  // namespace

Problems find_problems(const fs::path& config_file, DaemonConfig& config) {
  Problems problems;
  problems.errors = parse_daemon_config(recording::read_text_file(config_file), config_file, config);
  // What the text says is wrong would be said twice by what follows from it.
  const bool is_sound = problems.errors.empty();
  check_folder("[depth] socket", config.depth.socket.parent_path(), problems);
  check_folder("[control] socket", config.control.socket.parent_path(), problems);
  if (!config.metrics.file.empty())
    check_folder("[metrics] file", config.metrics.file.parent_path(), problems);
  if (!config.record.folder.empty()) check_folder("[record] folder", config.record.folder, problems);
  if (!is_sound) return problems;
  try {
    const Setup setup(config);
    if (config.source.events != EventsFrom::kReplay && is_served(config.control.socket)) {
      problems.warnings.push_back(
          config.control.socket.string() +
          ": a daemon runs with this socket and may be using the devices: they were not "
          "opened. Stop it to have them checked.");
    } else {
      Recorder nobody{RecordConfig{}};
      static_cast<void>(open_sources(setup, nobody));
    }
    check_limits(config, setup.arena_bytes, problems);
  } catch (const recording::Error& error) {
    problems.errors.emplace_back(error.what());
  } catch (const fs::filesystem_error& error) {
    problems.errors.emplace_back(recording::refused(error).what());
  }
  return problems;
}

}  // namespace egofocus::daemon
