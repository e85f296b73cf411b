// make_planes_fixture DIR: writes the recording that fixtures/planes holds.
#include <cstdio>
#include <filesystem>

#include "recording/error.hpp"
#include "recording/folder.hpp"
#include "recording/png_io.hpp"
#include "recording/raw_file.hpp"
#include "recording/text_file.hpp"
#include "support/planes_recording.hpp"

int main(int argc, char** argv) {
  using namespace egofocus;
  if (argc != 2) {
    std::fputs("usage: make_planes_fixture DIR\n", stderr);
    return static_cast<int>(recording::ExitCode::kUsage);
  }
  try {
    const std::filesystem::path folder = argv[1];
    std::filesystem::create_directories(folder / "depth");
    sim::PlaneSimulator simulator;
    const Intrinsics& camera = simulator.camera().config.camera.intrinsics;
    recording::write_raw_file(
        folder / "events.raw", simulator.events(),
        {static_cast<std::uint16_t>(camera.width_px), static_cast<std::uint16_t>(camera.height_px)});
    for (const auto& [name, content] : sim::planes_texts(simulator)) {
      recording::write_text_file(folder / name, content);
      std::printf("%-12s %9zu bytes\n", name.c_str(), content.size());
    }
    for (const std::int64_t t_us : sim::planes_ticks(simulator)) {
      recording::write_png(folder / recording::depth_name(t_us), simulator.depth(t_us));
    }
    return 0;
  } catch (const recording::Error& error) {
    std::fprintf(stderr, "make_planes_fixture: %s\n", error.what());
    return error.exit_code();
  }
}
