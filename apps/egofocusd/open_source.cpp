#include "open_source.hpp"

#include "core/clock.hpp"
#include "live_sources.hpp"
#include "paced_source.hpp"
#include "recording/folder.hpp"
#include "recording/recording_source.hpp"

namespace egofocus::daemon {
namespace {

std::int64_t period_us(const Setup& setup) {
  return static_cast<std::int64_t>(1e6 / setup.camera.config.rate.rate_hz);
}

// As fast as ticks run, the recording's own times: exactly what `egofocus replay` attaches.
OpenSources replay_virtual(const Setup& setup) {
  struct Held {
    explicit Held(recording::Folder opened) : folder(std::move(opened)), source(folder) {}
    recording::Folder folder;
    recording::RecordingSource source;
  };
  auto held = std::make_shared<Held>(recording::open_folder(setup.daemon.source.recording));
  OpenSources open;
  open.to_attach = {held->source.source()};
  open.first_tick_us = held->source.default_first_tick_us(setup.camera.config.rate.rate_hz);
  open.ends_before = [last_us = held->source.last_event_us()](std::int64_t t_us) { return t_us > last_us; };
  open.kept = {std::move(held)};
  return open;
}

// As a camera and a bus would send it, now.
OpenSources replay_real(const Setup& setup, Recorder& recorder) {
  auto paced = std::make_shared<PacedSource>(recording::open_folder(setup.daemon.source.recording),
                                             setup.daemon.source.at_end == AtEnd::kRepeat, recorder);
  const Clock clock = monotonic_clock();
  OpenSources open;
  open.to_attach = {paced->source()};
  open.first_tick_us = clock.now_us(clock.self) + period_us(setup);
  open.ends_before = [source = paced.get()](std::int64_t t_us) { return source->ends_before(t_us); };
  open.kept = {std::move(paced)};
  return open;
}

}  // namespace

OpenSources open_sources(const Setup& setup, Recorder& recorder) {
  if (setup.daemon.source.events != EventsFrom::kReplay) {
    OpenSources open = open_live_sources(setup, recorder);
    const Clock clock = monotonic_clock();
    const SourceConfig& source = setup.daemon.source;
    open.first_tick_us = source.clock == ClockKind::kDevice ? source.first_tick_us
                                                            : clock.now_us(clock.self) + period_us(setup);
    open.ends_before = [](std::int64_t) { return false; };
    return open;
  }
  if (setup.daemon.source.clock == ClockKind::kVirtual) return replay_virtual(setup);
  return replay_real(setup, recorder);
}

}  // namespace egofocus::daemon
