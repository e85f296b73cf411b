// CAN frames -> motion samples, by a DBC and the roles of its signals.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/status.hpp"
#include "egofocus/types.hpp"
#include "hal/can_frame.hpp"
#include "hal/can_motion_config.hpp"
#include "hal/dbc.hpp"

namespace egofocus {

/// What one frame completed: gyro and accelerometer come as samples of their own.
struct MotionSamples {
  ImuSample imu[2];
  std::size_t imu_count = 0;
  OdometrySample odometry[2];
  std::size_t odometry_count = 0;
};

struct CanMotionCounters {
  std::uint64_t frames = 0;  ///< offered; each is in one of the next three
  std::uint64_t frames_used = 0;
  std::uint64_t frames_unknown = 0;  ///< an id without a role
  std::uint64_t frames_short = 0;    ///< lacked a signal that should have been there (the others were used)
  std::uint64_t invalid_values = 0;  ///< above raw_max, or not finite
  std::uint64_t samples = 0;
  std::uint64_t samples_invalid = 0;     ///< complete, but with an invalid value: dropped
  std::uint64_t samples_incomplete = 0;  ///< a part did not come in time: dropped
};

/// A sample may be spread over several frames. There are four kinds: gyro, accelerometer, wheels, body
/// velocity; one comes out when all its configured parts have come within the group window and with equal
/// counters. A part that comes again, another counter or a time outside the window begins the next sample.
/// Axes without a signal are 0 (a car's lone yaw rate).
/// Thread: one at a time. RT: feed yes, O(configured signals); configure is for set-up.
class CanMotionDecoder {
 public:
  /// Copies what it needs of both. Errors, with the decoder then empty: kMissingSignal (subject = role, value
  /// = index of the entry) if the DBC lacks a message or signal; kBadMotion for a role given twice, an axis
  /// map that is no permutation, a scale that is 0 or not finite, a negative window, too many or no entries.
  [[nodiscard]] Status configure(const CanMotionConfig& config, const Dbc& dbc) noexcept;

  /// `out` is overwritten.
  void feed(const CanFrame& frame, MotionSamples& out) noexcept;

  /// The frames that feed() has a use for, one filter a message. Returns their number.
  std::size_t filters(std::span<CanFilter, CanMotionConfig::kMaxSignals> out) const noexcept;
  [[nodiscard]] const CanMotionConfig& config() const noexcept { return config_; }

  [[nodiscard]] const CanMotionCounters& counters() const noexcept { return counters_; }

 private:
  enum Kind : std::uint8_t { kGyro, kAccel, kWheel, kVelocity, kKinds };
  static constexpr std::size_t kMaxParts = 16;

  // One configured signal, ready to be decoded.
  struct Part {
    std::uint16_t signal = 0;  // index into dbc_.signals
    std::uint64_t raw_max = UINT64_MAX;
    double scale = 1;
    double offset = 0;
    double unit = 1;
    Kind kind = kGyro;
    std::uint8_t slot = 0;  // in Group::values
  };
  // One message: its parts stand together in parts_.
  struct Route {
    CanFilter filter;
    std::uint8_t first_part = 0;
    std::uint8_t part_count = 0;
    std::int16_t counter = -1;  // index into dbc_.signals, or -1
  };
  // The counter of a frame, if its message has one.
  struct SampleCount {
    bool known = false;
    std::uint64_t value = 0;
  };
  // A sample that is being put together.
  struct Group {
    double values[kMaxParts] = {};
    std::uint32_t wanted = 0;  // a bit per slot
    std::uint32_t there = 0;
    std::int64_t first_us = 0;
    SampleCount count;  // of its first frame
    bool invalid = false;
  };

  Status build() noexcept;
  Status add_entry(std::size_t index, const DbcMessage& message, Route& route) noexcept;
  [[nodiscard]] Status missing(std::size_t index) const noexcept;
  [[nodiscard]] const Route* find_route(const CanFrame& frame) const noexcept;
  [[nodiscard]] bool belongs(const Group& group, std::uint32_t bit, std::int64_t t_us,
                             SampleCount count) const noexcept;
  void take(const Part& part, std::uint64_t raw, std::int64_t t_us, SampleCount count,
            MotionSamples& out) noexcept;
  void emit(Kind kind, std::int64_t t_us, MotionSamples& out) const noexcept;

  Dbc dbc_;
  CanMotionConfig config_;
  Route routes_[CanMotionConfig::kMaxSignals];
  std::size_t route_count_ = 0;
  Part parts_[CanMotionConfig::kMaxSignals];
  std::size_t part_count_ = 0;
  std::size_t wheels_ = 0;
  Group groups_[kKinds];
  CanMotionCounters counters_;
};

}  // namespace egofocus
