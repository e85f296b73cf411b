#include "recording/text_file.hpp"

#include <fstream>

#include "recording/error.hpp"

namespace egofocus::recording {

std::string read_text_file(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    throw Error(ExitCode::kFile, path.string(), "is a folder; a file is needed here.");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Error(ExitCode::kFile, path.string(), "cannot be opened. Check the path and the permissions.");
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (file.bad()) throw Error(ExitCode::kFile, path.string(), "could not be read to its end.");
  return text;
}

void write_text_file(const std::filesystem::path& path, std::string_view text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file)
    throw Error(ExitCode::kFile, path.string(),
                "cannot be written. Does the folder exist, is the disk full?");
}

}  // namespace egofocus::recording
