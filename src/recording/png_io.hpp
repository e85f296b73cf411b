// PNG files in the three forms that recordings and results use: 8-bit grey, 8-bit RGB, 16-bit grey.
// Without libpng at build time each function but png_header() throws an Error that says so.
#pragma once

#include <filesystem>

#include "recording/picture.hpp"

namespace egofocus::recording {

/// Was the library built with libpng?
[[nodiscard]] bool png_available() noexcept;

/// Overwrites the file, whole or not at all. Throws Error (kFile) when it cannot be written.
void write_png(const std::filesystem::path& path, const GreyPicture& picture);
void write_png(const std::filesystem::path& path, const Grey16Picture& picture);
void write_png(const std::filesystem::path& path, const RgbPicture& picture);

/// The file must have exactly the asked form and at most 16384 px a side. Throws Error: kFile when missing,
/// kBadFile when truncated, damaged or of another form (the message names the form found).
[[nodiscard]] GreyPicture read_grey_png(const std::filesystem::path& path);
[[nodiscard]] Grey16Picture read_grey16_png(const std::filesystem::path& path);
[[nodiscard]] RgbPicture read_rgb_png(const std::filesystem::path& path);

struct PngHeader {
  std::int64_t width_px = 0;
  std::int64_t height_px = 0;
  int bit_depth = 0;
  const char* colour = "";  ///< "grey", "RGB", "palette", "grey + alpha", "RGBA" or "unknown"
};

/// Reads the first chunk alone; needs no libpng. Throws as above.
[[nodiscard]] PngHeader png_header(const std::filesystem::path& path);

}  // namespace egofocus::recording
