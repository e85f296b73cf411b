// Events -> Prophesee EVT 3.0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/types.hpp"
#include "hal/decoded.hpp"
#include "hal/evt_encoder_counters.hpp"
#include "hal/evt_time_high.hpp"

namespace egofocus {

/// The decoder gives back exactly the events that went in, times included, if they are sorted by time and t
/// >= 0. From time 0 to the first event, and in silences, it writes one word per 4.2 s: subtract an origin
/// from times that count from an epoch. Vectors are used where they are shorter than single events. Source:
/// facts, B3. Thread: one. RT: yes, O(events).
class Evt3Encoder {
 public:
  static constexpr std::size_t kMinRoomBytes = 8;  ///< with less, encode() does nothing

  /// Takes events until they or the room end; what was taken is wholly written. Call again with the rest.
  Decoded encode(std::span<const Event> events, std::span<std::byte> out) noexcept;

  [[nodiscard]] const EvtEncoderCounters& counters() const noexcept { return counters_; }

 private:
  bool owes(const Event& event, std::uint16_t& word) noexcept;

  // What a decoder holds after the words written so far; -1: nothing yet.
  TimeHighWriter time_high_{12};
  std::int32_t time_low_ = -1;
  std::int32_t y_ = -1;
  EvtEncoderCounters counters_;
};

}  // namespace egofocus
