// A folder that appears whole or not at all.
#pragma once

#include <filesystem>

namespace egofocus::recording {

/// Files are written into `<output>.partial`, which finish() renames. Without finish() the destructor removes
/// it; a program that was killed leaves it behind, and the next one starts it anew.
class OutputFolder {
 public:
  /// Writes nothing yet. Throws Error (kUsage) when `output` is a recording, a file, or a folder with
  /// content.
  explicit OutputFolder(std::filesystem::path output);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Makes the partial folder, empty. Throws Error (kFile).
  void create();

  /// Throws Error (kFile) when the rename fails; the partial folder is then removed.
  void finish();

  /// A file inside the partial folder.
  [[nodiscard]] std::filesystem::path operator/(const std::filesystem::path& name) const {
    return partial_ / name;
  }

 private:
  std::filesystem::path output_;
  std::filesystem::path partial_;
  bool created_ = false;
};

}  // namespace egofocus::recording
