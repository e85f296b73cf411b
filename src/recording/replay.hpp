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
#include "hal/can_motion_decoder.hpp"
#include "hal/evt_decoder.hpp"
#include "hal/replay_source.hpp"
#include "recording/error.hpp"
#include "recording/event_reader.hpp"
#include "recording/folder.hpp"

namespace egofocus::recording {

/// Throws Error with the Status's text when it is not ok.
void require(const Status& status, const std::string& where, ExitCode code = ExitCode::kConfiguration);

/// The decoder of a recording's CAN log, by its DBC and [can]. Throws Error.
[[nodiscard]] std::unique_ptr<CanMotionDecoder> make_can_decoder(const Folder& folder);

/// An engine with its arena, its recording and its replay source, under the virtual clock. Not for real time:
/// the set-up uses the heap. Move-free, since the engine refers to the source.
class Replay {
 public:
  /// `folder.camera.config` is the configuration; change it before. Throws Error.
  explicit Replay(Folder folder);
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;

  /// Where the tick grid begins when nobody says otherwise: the first depth truth; without truth the first
  /// whole period after the first event.
  [[nodiscard]] std::int64_t default_first_tick_us() const;

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
  [[nodiscard]] ReplayCounters counters() const { return source_->counters(); }
  [[nodiscard]] const ArenaBytes& arena_bytes() const { return arena_bytes_; }
  [[nodiscard]] std::int64_t first_event_us() const { return first_event_us_; }
  [[nodiscard]] std::int64_t last_event_us() const { return last_event_us_; }
  [[nodiscard]] std::uint64_t event_count() const { return event_count_; }
  /// Bytes of the last word of events.raw when the file ends inside it.
  [[nodiscard]] std::size_t cut_off_bytes() const { return cut_off_bytes_; }

 private:
  void scan_events();

  struct FreeArena {
    void operator()(void* block) const { std::free(block); }
  };

  Folder folder_;
  std::unique_ptr<CanMotionDecoder> can_motion_;
  std::unique_ptr<ReplaySource> source_;
  std::optional<EventReader> reader_;  // of the same events, for pictures
  std::int64_t first_event_us_ = 0;
  std::int64_t last_event_us_ = 0;
  std::uint64_t event_count_ = 0;
  std::size_t cut_off_bytes_ = 0;
  ArenaBytes arena_bytes_;
  std::unique_ptr<void, FreeArena> arena_;
  Engine engine_;  // last: it goes first
};

/// A log that holds nothing usable is found only by running: throws Error (kMotion) when ticks ran, and not
/// one of them knew how the camera moved.
void check_motion(Replay& replay);

}  // namespace egofocus::recording
