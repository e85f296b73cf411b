#include "recording/replay.hpp"

#include <string>

#include "recording/error.hpp"

namespace egofocus::recording {

Replay::Replay(Folder folder)
    : folder_(std::move(folder)), source_(folder_), reader_(folder_.events.bytes(), source_.header()) {
  const std::string camera = (folder_.path / "camera.toml").string();
  require(Engine::required_arena(config(), arena_bytes_), camera);
  const std::size_t bytes = arena_bytes_.all;
  arena_.reset(std::aligned_alloc(64, bytes));
  if (!arena_)
    throw Error(ExitCode::kInternal, "no memory for an arena of " + std::to_string(bytes) + " bytes");
  require(engine_.configure(config(), {static_cast<std::byte*>(arena_.get()), bytes}), camera);
  require(engine_.attach(source_.source()), "replay", ExitCode::kInternal);
}

void Replay::start(std::int64_t first_tick_us) {
  require(engine_.start(ClockKind::kVirtual, first_tick_us), folder_.path.string(), ExitCode::kBadFile);
}

void Replay::set_next_tick(std::int64_t t_us) {
  require(engine_.set_next_tick(t_us), folder_.path.string(), ExitCode::kInternal);
}

bool Replay::tick(DepthFrame& frame) {
  if (engine_.next_tick_us() > last_event_us()) return false;
  return engine_.tick() && engine_.newest(frame);
}

std::span<const Event> Replay::events_between(std::int64_t first_us, std::int64_t last_us) {
  return reader_.between(first_us, last_us);
}

void check_motion(Replay& replay) {
  const TickCounters ticks = replay.engine().health().ticks;
  if (ticks.run == 0 || ticks.no_motion < ticks.run) return;
  const bool poses = replay.config().motion.source == MotionSource::kPoses;
  throw Error(ExitCode::kMotion, (replay.folder().path / (poses ? "poses.txt" : "can.log")).string(),
              "no motion before any of the " + std::to_string(ticks.run) + " ticks. " +
                  (poses ? "Choose a later tick with --first-tick-us."
                         : "Is it a `candump -L` log with the frames that camera.toml and the DBC name?"));
}

}  // namespace egofocus::recording
