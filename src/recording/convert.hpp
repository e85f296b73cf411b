// Any known layout -> a recording folder: what `egofocus convert` runs.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "recording/conversion.hpp"

namespace egofocus::recording {

enum class InputFormat : std::uint8_t { kEcd, kMvsec, kDsec, kAedat4 };

/// "ecd", "mvsec", "dsec", "aedat4". Nothing for another word.
[[nodiscard]] std::optional<InputFormat> input_format_of(std::string_view name);

/// From what the folder holds, or from how the file begins; a folder of no known layout counts as ECD, whose
/// converter says what is missing. Throws Error: kFile (missing), kBadFile (a file of no known layout).
[[nodiscard]] InputFormat guess_format(const std::filesystem::path& input);

/// Throws Error.
ConvertReport convert(InputFormat format, const std::filesystem::path& input,
                      const std::filesystem::path& output, const ConvertOptions& options);

}  // namespace egofocus::recording
