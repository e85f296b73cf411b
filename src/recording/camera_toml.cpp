#include "recording/camera_toml.hpp"

#include "recording/camera_schema.hpp"
#include "recording/error.hpp"
#include "recording/text_file.hpp"
#include "recording/toml_reader.hpp"

namespace egofocus::recording {

CameraFile parse_camera_toml(std::string_view text, const std::string& name) {
  CameraFile file;
  try {
    const toml::table root = toml::parse(text, name);
    FileReader reader(root, name);
    describe_file(reader, file);
    reader.finish();
    if (!root.contains("camera")) {
      throw Error(ExitCode::kConfiguration, name,
                  "lacks the section [camera]. Add it; docs/formats.md has an example.");
    }
  } catch (const toml::parse_error& error) {
    fail(name, error.source(), "is no valid TOML: " + std::string(error.description()));
  }
  return file;
}

CameraFile read_camera_toml(const std::filesystem::path& path) {
  return parse_camera_toml(read_text_file(path), path.string());
}

}  // namespace egofocus::recording
