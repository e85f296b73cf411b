#include <cstdio>

#include "citysim/commands.hpp"
#include "recording/error.hpp"

namespace egofocus::citysim {

using recording::Error;
using recording::ExitCode;

std::string about_families() {
  std::string text = "Families:\n";
  for (const FamilyName& family : families()) {
    char line[120];
    std::snprintf(line, sizeof line, "  %-12s %s\n", std::string(family.name).c_str(),
                  std::string(family.about).c_str());
    text += line;
  }
  return text;
}

Family parse_family(const std::string& name) {
  const std::optional<Family> family = family_of(name);
  if (family) return *family;
  std::string known;
  for (const FamilyName& each : families()) known += (known.empty() ? "" : ", ") + std::string(each.name);
  throw Error(ExitCode::kUsage, "'" + name + "'", "is no family. There are: " + known + ".");
}

void parse_size(const std::string& text, int& width_px, int& height_px) {
  int used = 0;
  if (std::sscanf(text.c_str(), "%4dx%4d%n", &width_px, &height_px, &used) != 2 ||
      static_cast<std::size_t>(used) != text.size() || width_px < 64 || width_px > 1280 || height_px < 64 ||
      height_px > 1280) {
    throw Error(ExitCode::kUsage, "--size", "must look like 346x260, each side within 64..1280.");
  }
}

}  // namespace egofocus::citysim
