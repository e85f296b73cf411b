// A file mapped read-only into memory: large recordings cost no copy.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace egofocus::recording {

/// Owns the mapping. The file must not be shortened by others while it is mapped.
class MappedFile {
 public:
  MappedFile() = default;
  /// Throws Error (kFile) when the file is missing or cannot be mapped. An empty file gives an empty span.
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;

  [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return {data_, size_}; }
  [[nodiscard]] std::string_view text() const noexcept {
    return {reinterpret_cast<const char*>(data_), size_};
  }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace egofocus::recording
