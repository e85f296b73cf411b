// Arrays for numpy: `numpy.load(path)` gives [height, width]. Format 1.0, little-endian.
#pragma once

#include <filesystem>

#include "recording/picture.hpp"

namespace egofocus::recording {

/// Overwrites the file. Throws Error (kFile).
void write_npy(const std::filesystem::path& path, const Picture<float>& picture);
void write_npy(const std::filesystem::path& path, const GreyPicture& picture);

}  // namespace egofocus::recording
