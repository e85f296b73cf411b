// A file that appears whole or not at all.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

namespace egofocus::recording {

/// Bytes go into `<path>.partial`, which finish() renames. Without finish() the destructor removes it, and
/// what was at `path` before is still there. Devices and pipes, and all below /dev and /proc, are written
/// directly.
class WholeFile {
 public:
  /// Creates or overwrites. Throws Error (kFile).
  explicit WholeFile(const std::filesystem::path& path);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  /// Throws Error (kFile).
  void write(std::string_view bytes);

  /// For libraries that write by themselves; finish() sees what they met.
  [[nodiscard]] std::FILE* file() { return file_; }

  /// Throws Error (kFile) when not all could be written.
  void finish();

  /// "cannot be written (REASON) ...". The reason is errno's where it has one.
  [[noreturn]] void refuse(const std::string& reason) const;

 private:
  std::filesystem::path path_;     // as given, for messages
  std::filesystem::path target_;   // where links lead
  std::filesystem::path partial_;  // empty: written directly
  std::FILE* file_ = nullptr;
};

}  // namespace egofocus::recording
