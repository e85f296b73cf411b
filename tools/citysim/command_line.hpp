// What the commands share in reading their arguments.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "recording/error.hpp"

namespace egofocus::citysim {

/// True when the command is to run; false when --help was asked for and shown, or the arguments are wrong and
/// the reason was shown: then `code` is the exit code.
inline bool parse(CLI::App& program, std::span<const std::string> arguments, int& code) {
  std::vector<std::string> backwards(arguments.rbegin(), arguments.rend());  // as CLI11 wants them
  try {
    program.parse(backwards);
    return true;
  } catch (const CLI::ParseError& error) {
    code = program.exit(error) == 0 ? static_cast<int>(recording::ExitCode::kOk)
                                    : static_cast<int>(recording::ExitCode::kUsage);
    return false;
  }
}

}  // namespace egofocus::citysim
