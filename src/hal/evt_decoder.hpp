// One decoder for whichever EVT format a header or a device names.
#pragma once

#include <cstddef>
#include <span>

#include "hal/evt21_decoder.hpp"
#include "hal/evt2_decoder.hpp"
#include "hal/evt3_decoder.hpp"
#include "hal/raw_header.hpp"

namespace egofocus {

/// Holds all three decoders, a few hundred bytes, and feeds one of them. Thread: one. RT: yes, O(bytes).
class EvtDecoder {
 public:
  EvtDecoder(EvtFormat format, SensorSize size) noexcept
      : evt2_(size),
        evt21_(size, format == EvtFormat::kEvt21 ? Evt21Order::kLittleEndian : Evt21Order::kLegacy),
        evt3_(size),
        format_(format) {}

  /// Promise and protocol: see Decoded. Thread: one. RT: yes.
  Decoded feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept {
    switch (format_) {
      case EvtFormat::kEvt2:
        return evt2_.feed(bytes, out);
      case EvtFormat::kEvt21:
      case EvtFormat::kEvt21Legacy:
        return evt21_.feed(bytes, out);
      case EvtFormat::kEvt3:
        break;
    }
    return evt3_.feed(bytes, out);
  }
  [[nodiscard]] const EvtCounters& counters() const noexcept {
    switch (format_) {
      case EvtFormat::kEvt2:
        return evt2_.counters();
      case EvtFormat::kEvt21:
      case EvtFormat::kEvt21Legacy:
        return evt21_.counters();
      case EvtFormat::kEvt3:
        break;
    }
    return evt3_.counters();
  }
  [[nodiscard]] EvtFormat format() const noexcept { return format_; }

 private:
  Evt2Decoder evt2_;
  Evt21Decoder evt21_;
  Evt3Decoder evt3_;
  EvtFormat format_;
};

}  // namespace egofocus
