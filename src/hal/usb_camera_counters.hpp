// All that a camera on USB brought, lost and went through.
#pragma once

#include <cstdint>

#include "egofocus/status.hpp"
#include "hal/evt_violations.hpp"
#include "hal/inivation_words.hpp"

namespace egofocus {

enum class UsbCameraPhase : std::uint8_t { kClosed, kStarting, kStreaming };

/// Counts since construction; they go on over losses and re-opens.
struct UsbCameraCounters {
  UsbCameraPhase phase = UsbCameraPhase::kClosed;
  Status last_error;  ///< of the newest loss or refused re-opening

  std::uint64_t events_pushed = 0;  ///< offered to the ring, which counts what it drops
  /// Events before the start was complete, or before device time could be mapped: dropped.
  std::uint64_t events_unmapped = 0;
  std::uint64_t imu_pushed = 0;
  std::uint64_t imu_unmapped = 0;
  std::uint64_t device_dropped = 0;  ///< what the camera says it dropped since its last start (iniVation)

  std::uint64_t bytes = 0;
  std::uint64_t transfers = 0;  ///< that ended, well or not
  std::uint64_t timed_out = 0;  ///< with or without data; normal where a family has a time-out
  std::uint64_t stalls = 0;
  std::uint64_t overflows = 0;       ///< transfers with more data than fits: lost
  std::uint64_t failed = 0;          ///< any other error
  std::uint64_t clock_restarts = 0;  ///< device time was reset or jumped

  std::uint64_t opened = 0;
  std::uint64_t lost = 0;     ///< unplugged, silent or failing beyond hope
  std::uint64_t refused = 0;  ///< attempts to open it again that failed

  EvtCounters evt;              ///< Prophesee
  InivationCounters inivation;  ///< DAVIS, DVXplorer
};

}  // namespace egofocus
