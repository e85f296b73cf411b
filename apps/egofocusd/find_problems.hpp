// Everything that would keep egofocusd from starting, found before it starts.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon_config.hpp"

namespace egofocus::daemon {

struct Problems {
  std::vector<std::string> errors;    ///< it will not start
  std::vector<std::string> warnings;  ///< it starts, and something that was wished for will be missing
};

/// All that can be found, a line each: file or key, what is wrong, what to do. Opens the sources, and closes
/// them again; but no device while a daemon runs with the same control socket, which may be using it: that is
/// a warning. `config_out` is what was understood. Throws Error (kFile) when the file cannot be read.
[[nodiscard]] Problems find_problems(const std::filesystem::path& config_file, DaemonConfig& config_out);

}  // namespace egofocus::daemon
