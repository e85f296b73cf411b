#include "setup.hpp"

#include "recording/recording_source.hpp"
#include "recording/text_file.hpp"

namespace egofocus::daemon {

Setup::Setup(const DaemonConfig& config)
    : daemon(config), config_text(recording::read_text_file(config.file)) {
  camera_file = config.source.events == EventsFrom::kReplay ? config.source.recording / "camera.toml"
                                                            : config.engine.camera;
  camera = recording::read_camera_toml(camera_file);
  if (!camera.can.dbc.empty()) dbc = recording::read_text_file(camera_file.parent_path() / camera.can.dbc);
  Config& engine = camera.config;
  engine.backend = config.engine.backend;
  engine.threads = config.engine.threads;
  if (config.engine.rate_hz) engine.rate.rate_hz = *config.engine.rate_hz;
  engine.rate.lateness_us = config.engine.lateness_us;
  engine.rate.max_late_us = config.engine.max_late_us;
  engine.rings.max_event_rate_hz = config.engine.max_event_rate_hz;
  engine.real_time = config.engine.real_time;
  if (!config.engine.model.empty()) {
    model.emplace(config.engine.model);
    engine.model = model->bytes();
  }
  recording::require(Engine::required_arena(engine, arena_bytes), camera_file.string());
}

const Intrinsics& Setup::grid() const noexcept {
  const Config& engine = camera.config;
  return engine.grid.width_px != 0 ? engine.grid : engine.camera.intrinsics;
}

}  // namespace egofocus::daemon
