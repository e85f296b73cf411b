// How samples come in: spans pushed into the inlets, or sources that push by themselves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/export.hpp"
#include "egofocus/status.hpp"
#include "egofocus/types.hpp"

namespace egofocus {

/// The writing ends of the four rings.
/// Thread: each kind has one writer at a time; different kinds may have different writers. RT: yes.
class EGOFOCUS_API Inlets {
 public:
  struct Rings;
  explicit Inlets(Rings& rings) noexcept : rings_(&rings) {}

  /// Takes what fits, in order; drops and counts the rest. Returns the number taken; events that
  /// RingConfig::max_event_rate_hz leaves out count as taken.
  std::size_t push(std::span<const Event> events) noexcept;
  std::size_t push(std::span<const ImuSample> samples) noexcept;
  std::size_t push(std::span<const OdometrySample> samples) noexcept;
  std::size_t push(std::span<const PoseSample> samples) noexcept;

  /// How many samples would surely be taken now.
  [[nodiscard]] std::size_t event_room() const noexcept;
  [[nodiscard]] std::size_t imu_room() const noexcept;
  [[nodiscard]] std::size_t odometry_room() const noexcept;
  [[nodiscard]] std::size_t pose_room() const noexcept;

 private:
  Rings* rings_;
};

/// Sees every event that is pushed, as it is pushed: before thinning, and whether or not the ring takes it.
/// For a recorder. Thread: the events' writer. RT: `events` must be, too.
struct EventTap {
  void* self = nullptr;
  void (*events)(void* self, std::span<const Event> pushed) noexcept = nullptr;
};

/// What one poll brought.
struct Delivery {
  /// Every sample of this source with t <= watermark_us has been pushed.
  std::int64_t watermark_us = INT64_MIN;
  bool ended = false;  ///< nothing will come any more
  Status status;       ///< of the transport; a lost device is a Status, not a hang
};

/// A sensor or a recording: one object and its four functions. Copied by value; the object must outlive the
/// engine. `poll` moves what is there up to `until_us` into the inlets, waits at most `timeout_us`, and never
/// blocks on a full ring: it returns and is called again.
struct Source {
  void* self = nullptr;
  const char* name = "";
  Status (*start)(void* self) noexcept = nullptr;
  Delivery (*poll)(void* self, Inlets& inlets, std::int64_t until_us,
                   std::int64_t timeout_us) noexcept = nullptr;
  void (*stop)(void* self) noexcept = nullptr;
};

}  // namespace egofocus
