// Whole files in and out; one kind of error for all of them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace egofocus::recording {

/// Throws Error (kFile) when the file is missing or cannot be read completely.
[[nodiscard]] std::string read_text_file(const std::filesystem::path& path);

/// Creates or overwrites, whole or not at all (whole_file.hpp). Throws Error (kFile) when not all could be
/// written.
void write_text_file(const std::filesystem::path& path, std::string_view text);

/// At the end of a program: throws Error (kFile) when not all of its output could be written.
void flush_standard_output();

}  // namespace egofocus::recording
