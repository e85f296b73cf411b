#include "recording/text_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>

#include "recording/error.hpp"
#include "recording/whole_file.hpp"

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
  WholeFile file(path);
  file.write(text);
  file.finish();
}

void flush_standard_output() {
  std::cout.flush();
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout) return;
  const std::string reason = errno != 0 ? std::strerror(errno) : "not all bytes were taken";
  throw Error(ExitCode::kFile, "standard output", "cannot be written (" + reason + "). Is the disk full?");
}

}  // namespace egofocus::recording
