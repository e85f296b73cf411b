#include "describe.hpp"
#include "recording/folder.hpp"

namespace egofocus::app {

Json describe_recording(const std::filesystem::path& path) {
  // Opened as a replay would open it, so that info complains about what a replay would complain about.
  const recording::Folder folder = recording::open_folder(path);
  Json facts;
  facts.add("kind", "recording folder").add("camera.toml", describe_file(path / "camera.toml"));
  facts.add("events.raw", describe_file(path / "events.raw"));
  if (!folder.can.bytes().empty()) facts.add("can.log", describe_file(path / "can.log"));
  if (!folder.dbc.empty()) facts.add(folder.camera.can.dbc, describe_file(path / folder.camera.can.dbc));
  if (!folder.poses.empty()) facts.add("poses.txt", describe_file(path / "poses.txt"));
  facts.add("depth_pictures", folder.truth.size());
  return facts;
}

}  // namespace egofocus::app
