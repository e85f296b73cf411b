// A recording as a source: what a camera and a CAN bus would have sent, from memory, as fast as it is asked
// for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/source.hpp"
#include "hal/can_motion_decoder.hpp"
#include "hal/candump_decoder.hpp"
#include "hal/evt_decoder.hpp"
#include "hal/pose_text_decoder.hpp"

namespace egofocus {

/// The files of a recording; each may be empty. The bytes outlive the source.
struct ReplayStreams {
  std::span<const std::byte> events_raw = {};  ///< any EVT format, header included
  std::span<const std::byte> can_log = {};     ///< candump -L
  std::span<const std::byte> poses_txt = {};   ///< t px py pz qx qy qz qw
  std::int64_t events_offset_us = 0;  ///< added to the device times of the events to get the recording's time
  CanMotionDecoder* can_motion =
      nullptr;  ///< configured; needed where can_log is not empty; outlives the source
  /// How much older than the frame that completes it a motion sample can be: can_lag_us() of the
  /// configuration.
  std::int64_t can_lag_us = 0;
  CanTap can_tap = {};
};

/// All that was read, used and left out, per stream.
struct ReplayCounters {
  EvtCounters events;
  CandumpCounters can_log;
  CanMotionCounters can_motion;
  PoseTextCounters poses;
  std::uint64_t events_pushed = 0;
  std::uint64_t imu_pushed = 0;
  std::uint64_t odometry_pushed = 0;
  std::uint64_t poses_pushed = 0;
};

/// A full backend. It never drops: a full ring makes it wait for the next poll, and the watermark says how
/// far it came. Within a stream, samples go out as they lie in the file. Thread: one, the writer of all four
/// inlets. RT: poll yes, O(bytes up to `until_us`).
class ReplaySource {
 public:
  explicit ReplaySource(const ReplayStreams& streams) noexcept : streams_(streams) {}
  ReplaySource(const ReplaySource&) = delete;
  ReplaySource& operator=(const ReplaySource&) = delete;

  /// The four functions over this object, which must outlive the copy.
  Source source() noexcept;

  /// Rewinds. Errors: those of parse_raw_header(); kBadState if there is a CAN log but no decoder for it.
  Status start() noexcept;
  /// See Source; waits for nothing, so `timeout_us` is not looked at.
  Delivery poll(Inlets& inlets, std::int64_t until_us) noexcept;

  [[nodiscard]] ReplayCounters counters() const noexcept;
  /// After start(), where there are events.
  [[nodiscard]] const RawHeader& header() const noexcept { return header_; }

 private:
  static constexpr std::size_t kStagedEvents = 256;
  static constexpr std::size_t kStagedPoses = 16;
  static constexpr std::size_t kStagedMotion = 64;

  // Samples in file order that wait for their time or for room.
  template <typename Sample, std::size_t kCapacity>
  struct Staged {
    std::array<Sample, kCapacity> items;
    std::size_t count = 0;
    std::size_t next = 0;
    [[nodiscard]] bool empty() const noexcept { return next == count; }
  };

  bool refill_events() noexcept;
  bool refill_poses() noexcept;
  bool read_frame() noexcept;
  [[nodiscard]] bool is_full() const noexcept;
  std::int64_t push_motion(Inlets& inlets, std::int64_t until_us) noexcept;
  std::int64_t pump_motion(Inlets& inlets, std::int64_t until_us) noexcept;

  ReplayStreams streams_;
  RawHeader header_;
  EvtDecoder evt_{EvtFormat::kEvt3, {}};
  CandumpDecoder candump_;
  PoseTextDecoder pose_text_;
  std::span<const std::byte> events_left_;
  std::span<const std::byte> can_left_;
  std::span<const std::byte> poses_left_;
  Staged<Event, kStagedEvents> events_;
  Staged<PoseSample, kStagedPoses> poses_;
  // Motion samples may be older than those before them, so these two are searched, not queued.
  std::array<ImuSample, kStagedMotion> imu_;
  std::array<OdometrySample, kStagedMotion> odometry_;
  std::size_t imu_count_ = 0;
  std::size_t odometry_count_ = 0;
  CanFrame frame_;
  bool has_frame_ = false;
  ReplayCounters pushed_;
};

}  // namespace egofocus
