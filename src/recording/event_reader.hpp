// The events of a recording by time, forward only, beside the engine: for pictures and masks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "egofocus/types.hpp"
#include "hal/evt_decoder.hpp"
#include "hal/raw_header.hpp"

namespace egofocus::recording {

class EventReader {
 public:
  /// `events_raw`: a whole file, with the header that was parsed from it; it outlives the reader.
  EventReader(std::span<const std::byte> events_raw, const RawHeader& header);

  /// Events with first_us < t <= last_us, until the next call. Neither time may go back from call to call;
  /// stretches may overlap.
  [[nodiscard]] std::span<const Event> between(std::int64_t first_us, std::int64_t last_us);

 private:
  EvtDecoder decoder_;
  std::span<const std::byte> left_;
  std::vector<Event> events_;
};

}  // namespace egofocus::recording
