// A live event sensor behind V4L2 as a source: found, streamed, lost, found again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/clock.hpp"
#include "core/snapshot.hpp"
#include "egofocus/source.hpp"
#include "hal/clock_map.hpp"
#include "hal/evt_frame_end.hpp"
#include "hal/evt_samples.hpp"
#include "hal/retry_pause.hpp"
#include "hal/v4l2_buffers.hpp"
#include "hal/v4l2_camera.hpp"

namespace egofocus {

/// Counts since construction; they go on over losses and re-opens. Every buffer that was taken is in
/// `decoded` or in one of the four lines below it.
struct V4l2CameraCounters {
  bool is_streaming = false;
  Status last_error;  ///< of the newest loss or refused re-opening

  std::uint64_t buffers = 0;  ///< taken from the driver
  std::uint64_t decoded = 0;
  std::uint64_t empty = 0;
  std::uint64_t damaged = 0;           ///< the driver's error flag: dropped
  std::uint64_t wrong = 0;             ///< more bytes used than there are: dropped
  std::uint64_t unmarked_refused = 0;  ///< no end-of-frame marker: dropped
  std::uint64_t unmarked_decoded = 0;  ///< no end-of-frame marker, decoded all the same (in `decoded`, too)
  std::uint64_t lost_buffers = 0;      ///< gaps in the driver's sequence
  std::uint64_t bytes = 0;             ///< that were decoded
  std::uint64_t without_stamp = 0;     ///< no usable time stamp: the time of taking was used
  std::uint64_t poll_errors = 0;

  std::uint64_t opened = 0;
  std::uint64_t lost = 0;     ///< gone, silent or failing beyond hope
  std::uint64_t refused = 0;  ///< attempts to open it again that failed

  EvtSampleCounters samples;
  EvtCounters evt;
  ClockMapCounters clock;
};

/// open() finds the device and configures it, start() starts the stream, poll() takes what is there: each
/// buffer is copied as far as it is valid, given back at once, and decoded from the copy. After anything that
/// was lost the decoder waits for the next TIME_HIGH. A device that is gone, silent or failing is closed, and
/// with settings.reopen looked for again after 0.1 s, 0.2 s, ... 2 s.
///
/// Allocates nothing. Times are the host's: buffer stamps of the kernel with the newest device time in the
/// buffer make the map (ClockMap).
/// Thread: one calls open .. stop and writes the event inlet; counters() from any. RT: poll yes but for
/// re-opening; it takes at most as many buffers as the driver has.
class V4l2CameraSource {
 public:
  /// Bytes for `copy`: the largest buffer that is taken. Thread: any. RT: yes.
  static std::size_t buffer_bytes(const V4l2CameraSettings& settings) noexcept {
    return settings.frame_bytes > 0 ? static_cast<std::size_t>(settings.frame_bytes) : 0;
  }

  /// `copy` and what `io` points to outlive the source.
  V4l2CameraSource(const V4l2CameraSettings& settings, std::span<std::byte> copy, Clock clock,
                   const V4l2Io& io = system_v4l2_io()) noexcept
      : settings_(settings), copy_(copy), clock_(clock), io_(io) {}
  ~V4l2CameraSource() { stop(); }
  V4l2CameraSource(const V4l2CameraSource&) = delete;
  V4l2CameraSource& operator=(const V4l2CameraSource&) = delete;

  /// The functions over this object, which must outlive the copy.
  Source source() noexcept;

  /// kArenaTooSmall (copy) and the errors of open_v4l2_camera(). On failure all is closed. RT: no.
  Status open() noexcept;
  /// Opens when that has not been done. kDeviceBusy when another process streams, and those of open(). RT:
  /// no.
  Status start() noexcept;
  /// See Source. Live: what is there is pushed whatever its time. Without settings.reopen a loss is the
  /// status kDeviceLost.
  Delivery poll(Inlets& inlets, std::int64_t timeout_us) noexcept;
  /// Stops the stream and closes. RT: no.
  void stop() noexcept;

  /// After open(), also after one that was refused: what had been read until then.
  [[nodiscard]] const V4l2CameraInfo& info() const noexcept { return info_; }
  /// Newest complete snapshot; untouched counters before the first poll.
  [[nodiscard]] V4l2CameraCounters counters() const noexcept;

 private:
  [[nodiscard]] std::int64_t now_us() const noexcept { return clock_.now_us(clock_.self); }
  void stream(Inlets& inlets, std::int64_t timeout_us) noexcept;
  int take_all(Inlets& inlets) noexcept;
  int take(const V4l2Filled& filled, Inlets& inlets) noexcept;
  std::size_t copy_valid(const V4l2Filled& filled) noexcept;
  void check_sequence(std::uint32_t sequence) noexcept;
  std::int64_t time_of(const V4l2Filled& filled) noexcept;
  void lose(int error, const char* subject) noexcept;
  void look_again(std::int64_t timeout_us) noexcept;
  void close() noexcept;
  void publish() noexcept;

  V4l2CameraSettings settings_;
  std::span<std::byte> copy_;
  Clock clock_;
  V4l2Io io_;

  V4l2File node_{io_};
  V4l2Buffers buffers_{node_};
  V4l2CameraInfo info_;
  EvtSamples samples_;
  V4l2CameraCounters counts_;  // the polling thread's own
  Snapshot<V4l2CameraCounters> published_;
  RetryPause retry_;
  bool was_started_ = false;
  bool has_sequence_ = false;
  std::uint32_t sequence_ = 0;
  int failures_in_a_row_ = 0;
  std::int64_t last_data_us_ = 0;
};

}  // namespace egofocus
