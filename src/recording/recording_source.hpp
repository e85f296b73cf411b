// The files of a recording as a source for an engine, and what they say before anything runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "egofocus/source.hpp"
#include "egofocus/status.hpp"
#include "hal/can_motion_decoder.hpp"
#include "hal/raw_header.hpp"
#include "hal/replay_source.hpp"
#include "recording/error.hpp"
#include "recording/folder.hpp"

namespace egofocus::recording {

/// Throws Error with the Status's text when it is not ok.
void require(const Status& status, const std::string& where, ExitCode code = ExitCode::kConfiguration);

/// The decoder of [can] with the text of its DBC, which came from `file`. Throws Error.
[[nodiscard]] std::unique_ptr<CanMotionDecoder> make_can_decoder(const CanSetup& can, std::string_view dbc,
                                                                 const std::filesystem::path& file);
/// That of a recording's CAN log.
[[nodiscard]] std::unique_ptr<CanMotionDecoder> make_can_decoder(const Folder& folder);

class RecordingSource {
 public:
  /// Reads all events once: first and last time, and a header that is refused before anything runs. `folder`
  /// outlives this. `tap` sees each CAN frame as it is read. Throws Error.
  explicit RecordingSource(const Folder& folder, CanTap tap = {});
  RecordingSource(const RecordingSource&) = delete;
  RecordingSource& operator=(const RecordingSource&) = delete;

  /// This object must outlive the copy.
  [[nodiscard]] Source source() noexcept { return source_->source(); }

  /// Where the tick grid begins when nobody says otherwise: the first depth truth; without truth the first
  /// whole period after the first event.
  [[nodiscard]] std::int64_t default_first_tick_us(double rate_hz) const;

  [[nodiscard]] ReplayCounters counters() const { return source_->counters(); }
  [[nodiscard]] const RawHeader& header() const { return header_; }
  [[nodiscard]] std::int64_t first_event_us() const { return first_event_us_; }
  [[nodiscard]] std::int64_t last_event_us() const { return last_event_us_; }
  [[nodiscard]] std::uint64_t event_count() const { return event_count_; }
  /// Bytes of the last word of events.raw when the file ends inside it.
  [[nodiscard]] std::size_t cut_off_bytes() const { return cut_off_bytes_; }

 private:
  void scan_events();

  const Folder& folder_;
  std::unique_ptr<CanMotionDecoder> can_motion_;
  std::unique_ptr<ReplaySource> source_;
  RawHeader header_;
  std::int64_t first_event_us_ = 0;
  std::int64_t last_event_us_ = 0;
  std::uint64_t event_count_ = 0;
  std::size_t cut_off_bytes_ = 0;
};

}  // namespace egofocus::recording
