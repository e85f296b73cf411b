// Records what the sources give, on request: a recording folder as docs/formats.md has it, for `egofocus
// replay`. Two rings between the sources' threads and the disk's: what does not fit is dropped and counted.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/ring.hpp"
#include "daemon_config.hpp"
#include "descriptor.hpp"
#include "egofocus/types.hpp"
#include "hal/can_frame.hpp"
#include "hal/evt3_encoder.hpp"
#include "hal/sensor_size.hpp"
#include "setup.hpp"

namespace egofocus::daemon {

struct RecorderFacts {
  bool on = false;
  std::string folder;                ///< of the last recording; empty before the first
  std::string failure;               ///< why the last one ended before it was told to; empty: it did not
  std::uint64_t bytes = 0;           ///< written to the last one
  std::uint64_t events_dropped = 0;  ///< since the daemon began: the disk was too slow
  std::uint64_t frames_dropped = 0;
  std::uint64_t not_encodable = 0;  ///< events of the last one that EVT3 cannot hold: unsorted ones
};

class Recorder {
 public:
  explicit Recorder(const RecordConfig& config);

  /// Thread: one for events, one for frames. RT: yes. Nothing happens while no recording is on.
  void take(std::span<const Event> events) noexcept {
    if (on_.load(std::memory_order_acquire)) events_.push(events);
  }
  void take(const CanFrame& frame) noexcept {
    if (on_.load(std::memory_order_acquire)) frames_.push(std::span<const CanFrame>(&frame, 1));
  }

  /// A recording of what this setup gives, from `now_us` on. Throws Error when there is no folder for it,
  /// when one is on, or when motion does not come from a bus. Thread: the service's, as all below but work().
  void begin(const Setup& setup, std::int64_t now_us);
  /// False: there is none.
  bool end();
  /// A line for health.jsonl, if a recording is on.
  void note_health(const std::string& line);
  [[nodiscard]] RecorderFacts facts() const;

  /// Opens, writes and closes. Thread: the disk's, some fifty times a second.
  void work();

 private:
  struct Wish {
    std::int64_t origin_us = 0;
    std::string camera_toml, dbc_name, dbc, config, can_interface;
    SensorSize size;
  };

  void open(const Wish& wish);
  void name_folder();
  void write_events();
  void write_frames();
  void drop_waiting();
  void close(const std::string& failure);
  void append(Descriptor& file, std::string_view bytes);
  [[nodiscard]] bool is_open() const { return events_file_.is_open(); }

  RecordConfig config_;
  std::vector<Event> event_slots_;
  std::vector<CanFrame> frame_slots_;
  SpscRing<Event> events_;
  SpscRing<CanFrame> frames_;
  std::atomic<bool> on_{false};

  mutable std::mutex guard_;  // of what the service and the disk share, here
  std::optional<Wish> wish_;
  bool end_asked_ = false;
  std::string health_lines_;
  RecorderFacts facts_;

  // The disk's own.
  std::filesystem::path partial_;
  std::filesystem::path folder_;
  Descriptor events_file_, can_file_, health_file_;
  Evt3Encoder encoder_;
  std::int64_t origin_us_ = 0;
  std::string can_interface_;
  std::uint64_t bytes_ = 0;
  std::vector<std::byte> encoded_;
};

}  // namespace egofocus::daemon
