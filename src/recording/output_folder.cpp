#include "recording/output_folder.hpp"

#include <utility>

#include "recording/error.hpp"
#include "recording/folder.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

// "out/" and "out" are the same folder, but only the second has a name that can be lengthened.
fs::path without_trailing_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

bool is_empty_folder(const fs::path& path) {
  std::error_code failure;
  return fs::is_directory(path, failure) && fs::is_empty(path, failure) && !failure;
}

}  // namespace

OutputFolder::OutputFolder(fs::path output) : output_(without_trailing_slash(std::move(output))) {
  partial_ = output_;
  partial_ += ".partial";
  if (is_recording(output_)) {
    throw Error(ExitCode::kUsage, output_.string(),
                "already holds a recording. Choose another folder, or remove it first.");
  }
  std::error_code ignored;
  if (output_.empty() || (fs::exists(output_, ignored) && !is_empty_folder(output_))) {
    throw Error(ExitCode::kUsage, output_.string(),
                "is there already and is no empty folder. Choose another name, or remove it first.");
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (created_) fs::remove_all(partial_, ignored);
}

void OutputFolder::create() {
  std::error_code failure;
  fs::remove_all(partial_, failure);
  if (!failure) fs::create_directories(partial_, failure);
  if (failure) {
    throw Error(ExitCode::kFile, partial_.string(),
                "cannot be made (" + failure.message() + "). May you write there?");
  }
  created_ = true;
}

void OutputFolder::finish() {
  std::error_code failure;
  fs::rename(partial_, output_, failure);
  if (failure) {
    throw Error(ExitCode::kFile, output_.string(),
                "cannot be made (" + failure.message() + "). May you write there?");
  }
  created_ = false;
}

}  // namespace egofocus::recording
