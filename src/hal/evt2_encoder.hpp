// Events -> Prophesee EVT 2.0.
#pragma once

#include <cstddef>
#include <span>

#include "egofocus/types.hpp"
#include "hal/decoded.hpp"
#include "hal/evt_encoder_counters.hpp"
#include "hal/evt_time_high.hpp"

namespace egofocus {

/// The decoder gives back exactly the events that went in, times included, if they are sorted by time and t
/// >= 0. From time 0 to the first event, and in silences, it writes one word per 1.2 hours. Source: facts,
/// B1. Thread: one. RT: yes, O(events).
class Evt2Encoder {
 public:
  static constexpr std::size_t kMinRoomBytes = 4;  ///< with less, encode() does nothing

  /// Takes events until they or the room end; what was taken is wholly written. Call again with the rest.
  Decoded encode(std::span<const Event> events, std::span<std::byte> out) noexcept;

  [[nodiscard]] const EvtEncoderCounters& counters() const noexcept { return counters_; }

 private:
  TimeHighWriter time_high_{28};
  EvtEncoderCounters counters_;
};

}  // namespace egofocus
