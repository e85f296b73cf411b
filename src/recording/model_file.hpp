// A model file of the network backend, mapped and checked.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "recording/mapped_file.hpp"

namespace egofocus::recording {

class ModelFile {
 public:
  /// Throws Error: kFile when it cannot be read, kBadFile with cause and place when it is no sound model.
  explicit ModelFile(const std::filesystem::path& path);
  /// For Config::model, as long as this lives.
  [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return file_.bytes(); }

 private:
  MappedFile file_;
};

}  // namespace egofocus::recording
