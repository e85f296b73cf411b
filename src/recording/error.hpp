// The one exception of the recording library and of the programs: what, where, what to do, and an exit code.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace egofocus::recording {

/// Exit codes of the programs. docs/formats.md repeats this table for users.
enum class ExitCode : int {
  kOk = 0,
  kInternal = 1,       ///< a defect of ours
  kUsage = 2,          ///< wrong command line
  kFile = 3,           ///< a file is missing, or cannot be read or written
  kBadFile = 4,        ///< a file is truncated or not what its name says
  kConfiguration = 5,  ///< camera.toml, intrinsics that do not fit, a DBC without the needed signals
  kMotion = 6,         ///< a recording without motion, or with a pose gap
  kNoEvents = 7,       ///< a recording without events in the asked span
  kNoDevice = 10,      ///< no such device is there, or this build cannot look for it
  kDevice = 11,        ///< there is one, and it cannot be used: permission, claimed, firmware
};

/// The message is one line for people and names the file, the line where there is one, and the remedy.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  /// "where: what"
  Error(ExitCode code, const std::string& where, const std::string& what)
      : Error(code, where + ": " + what) {}

  [[nodiscard]] int exit_code() const noexcept { return static_cast<int>(code_); }

 private:
  ExitCode code_;
};

/// What the file system refuses on the way is the user's to mend, not a defect of ours.
[[nodiscard]] inline Error refused(const std::filesystem::filesystem_error& error) {
  return {ExitCode::kFile, error.path1().string(),
          "cannot be read or written (" + error.code().message() +
              "). Check the path and the permissions; is the disk full?"};
}

}  // namespace egofocus::recording
