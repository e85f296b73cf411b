#include "recording/mapped_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <limits>
#include <utility>

#include "recording/error.hpp"

namespace egofocus::recording {
namespace {

struct Descriptor {
  int number;
  ~Descriptor() {
    if (number >= 0) close(number);
  }
};

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path) {
  const auto refuse = [&path] {
    throw Error(
        ExitCode::kFile, path.string(),
        std::string("cannot be read: ") + std::strerror(errno) + ". Check the path and the permissions.");
  };
  const Descriptor file{open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  struct stat about {};
  if (file.number < 0 || fstat(file.number, &about) != 0) refuse();
  if (!S_ISREG(about.st_mode)) throw Error(ExitCode::kFile, path.string(), "is no ordinary file.");
  if (static_cast<std::uint64_t>(about.st_size) > std::numeric_limits<std::size_t>::max() / 2) {
    throw Error(ExitCode::kFile, path.string(), "is too large for this machine's address space.");
  }
  if (about.st_size == 0) return;
  const auto size = static_cast<std::size_t>(about.st_size);
  void* const data = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.number, 0);
  if (data == MAP_FAILED) refuse();
  data_ = static_cast<const std::byte*>(data);
  size_ = size;
}

MappedFile::~MappedFile() {
  if (data_) munmap(const_cast<std::byte*>(data_), size_);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

}  // namespace egofocus::recording
