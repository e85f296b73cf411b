// A recording wired to an engine: what `egofocus replay` and the tests run.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "egofocus/engine.hpp"
#include "recording/error.hpp"
#include "recording/event_reader.hpp"
#include "recording/folder.hpp"
#include "recording/recording_source.hpp"

namespace egofocus::recording {

/// An engine with its arena, its recording and its replay source, under the virtual clock. Not for real time:
/// the set-up uses the heap. Move-free, since the engine refers to the source.
class Replay {
 public:
  /// `folder.camera.config` is the configuration; change it before. Throws Error.
  explicit Replay(Folder folder);
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;

  /// RecordingSource's, at the configured rate.
  [[nodiscard]] std::int64_t default_first_tick_us() const {
    return source_.default_first_tick_us(config().rate.rate_hz);
  }

  void start(std::int64_t first_tick_us);

  /// The next tick at this time instead of the grid's next point. Throws Error (kInternal) when the last tick
  /// was not before it.
  void set_next_tick(std::int64_t t_us);

  /// One tick. False at the end: the source has ended, or no event is left for the next tick.
  bool tick(DepthFrame& frame);

  /// Events (first_us, last_us] of the recording; calls go forward in time.
  std::span<const Event> events_between(std::int64_t first_us, std::int64_t last_us);

  [[nodiscard]] const Folder& folder() const { return folder_; }
  [[nodiscard]] const Config& config() const { return folder_.camera.config; }
  [[nodiscard]] Engine& engine() { return engine_; }
  [[nodiscard]] ReplayCounters counters() const { return source_.counters(); }
  [[nodiscard]] const ArenaBytes& arena_bytes() const { return arena_bytes_; }
  [[nodiscard]] std::int64_t first_event_us() const { return source_.first_event_us(); }
  [[nodiscard]] std::int64_t last_event_us() const { return source_.last_event_us(); }
  [[nodiscard]] std::uint64_t event_count() const { return source_.event_count(); }
  [[nodiscard]] std::size_t cut_off_bytes() const { return source_.cut_off_bytes(); }

 private:
  struct FreeArena {
    void operator()(void* block) const { std::free(block); }
  };

  Folder folder_;
  RecordingSource source_;
  EventReader reader_;  // of the same events, for pictures
  ArenaBytes arena_bytes_;
  std::unique_ptr<void, FreeArena> arena_;
  Engine engine_;  // last: it goes first
};

/// A log that holds nothing usable is found only by running: throws Error (kMotion) when ticks ran, and not
/// one of them knew how the camera moved.
void check_motion(Replay& replay);

}  // namespace egofocus::recording
