#include "recording/whole_file.hpp"

#include <cerrno>
#include <cstring>
#include <utility>

#include "recording/error.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

/// Nothing may take the place of these by a rename; /dev/stdout may even lead to a plain file that is open.
bool is_written_directly(const fs::path& path) {
  const std::string text = fs::absolute(path).lexically_normal().string();
  if (text.starts_with("/dev/") || text.starts_with("/proc/")) return true;
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// A link stays a link.
fs::path target_of(const fs::path& path) {
  std::error_code failure;
  fs::path target = fs::canonical(path, failure);
  return failure ? path : target;
}

}  // namespace

WholeFile::WholeFile(const fs::path& path) : path_(path), target_(path) {
  if (!is_written_directly(path)) {
    target_ = target_of(path);
    partial_ = target_;
    partial_ += ".partial";
  }
  errno = 0;
  file_ = std::fopen((partial_.empty() ? target_ : partial_).c_str(), "wb");
  if (file_ == nullptr) refuse("no reason given");
}

WholeFile::~WholeFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  std::error_code ignored;
  if (!partial_.empty()) fs::remove(partial_, ignored);
}

void WholeFile::write(std::string_view bytes) {
  errno = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) refuse("not all bytes were taken");
}

void WholeFile::finish() {
  errno = 0;
  if (std::fflush(file_) != 0 || std::ferror(file_) != 0) refuse("not all bytes were taken");
  const bool closed = std::fclose(std::exchange(file_, nullptr)) == 0;
  const int reason = errno;
  if (partial_.empty()) {
    if (!closed) refuse("it cannot be closed");
    return;
  }
  std::error_code failure(closed ? 0 : reason, std::generic_category());
  if (closed) fs::rename(partial_, target_, failure);
  if (!failure) return;
  std::error_code ignored;
  fs::remove(partial_, ignored);
  errno = 0;
  refuse(failure.message());
}

void WholeFile::refuse(const std::string& reason) const {
  const std::string text = errno != 0 ? std::strerror(errno) : reason;
  throw Error(ExitCode::kFile, path_.string(),
              "cannot be written (" + text + "). Does the folder exist, is the disk full?");
}

}  // namespace egofocus::recording
