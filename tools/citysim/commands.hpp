// The commands of citysim, one file each. Each parses its own arguments (the command's name left out),
// prints, and returns an exit code of docs/formats.md; each throws recording::Error.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "citysim/world.hpp"

namespace egofocus::citysim {

int run_record(std::span<const std::string> arguments);   ///< `citysim FAMILY ...`
int run_samples(std::span<const std::string> arguments);  ///< `citysim samples ...`
int run_stats(std::span<const std::string> arguments);    ///< `citysim stats ...`

/// "Families: ..." for --help.
[[nodiscard]] std::string about_families();
/// Throws recording::Error (kUsage), naming the families there are.
[[nodiscard]] Family parse_family(const std::string& name);
/// "346x260"; throws recording::Error (kUsage).
void parse_size(const std::string& text, int& width_px, int& height_px);

}  // namespace egofocus::citysim
