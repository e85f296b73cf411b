// What a file or folder is, as facts. Nothing here changes a file.
#pragma once

#include <filesystem>

#include "recording/json.hpp"

namespace egofocus::app {

using recording::Json;

/// Tells the kind by content, then by name. Throws recording::Error when the file is missing, damaged or of
/// no known kind.
Json describe_file(const std::filesystem::path& path);

/// A recording folder: all its parts.
Json describe_recording(const std::filesystem::path& path);

}  // namespace egofocus::app
