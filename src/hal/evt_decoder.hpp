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
  // Calls `use` with the decoder of the format.
  template <typename Self, typename Use>
  static decltype(auto) with(Self& self, Use use) noexcept {
    switch (self.format_) {
      case EvtFormat::kEvt2:
        return use(self.evt2_);
      case EvtFormat::kEvt21:
      case EvtFormat::kEvt21Legacy:
        return use(self.evt21_);
      case EvtFormat::kEvt3:
        break;
    }
    return use(self.evt3_);
  }

 public:
  /// `so_far`: counts to go on from, of a decoder before this one.
  EvtDecoder(EvtFormat format, SensorSize size, const EvtCounters& so_far = {}) noexcept
      : evt2_(size, so_far),
        evt21_(size, format == EvtFormat::kEvt21 ? Evt21Order::kLittleEndian : Evt21Order::kLegacy, so_far),
        evt3_(size, so_far),
        format_(format) {}

  /// Promise and protocol: see Decoded. Thread: one. RT: yes.
  Decoded feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept {
    return with(*this, [&](auto& decoder) noexcept { return decoder.feed(bytes, out); });
  }
  /// Data before the next bytes were lost. See the decoders. Thread: one. RT: yes.
  void resync() noexcept {
    with(*this, [](auto& decoder) noexcept { decoder.resync(); });
  }
  /// Half a word at the end of what was fed is dropped and counted. Thread: one. RT: yes.
  void drop_partial() noexcept {
    with(*this, [](auto& decoder) noexcept { decoder.drop_partial(); });
  }

  /// Newest device time; moves on without events, too. Precondition: is_time_known().
  [[nodiscard]] std::int64_t time_us() const noexcept {
    return with(*this, [](const auto& decoder) noexcept { return decoder.time_us(); });
  }
  [[nodiscard]] bool is_time_known() const noexcept {
    return with(*this, [](const auto& decoder) noexcept { return decoder.is_time_known(); });
  }
  [[nodiscard]] const EvtCounters& counters() const noexcept {
    return with(*this, [](const auto& decoder) noexcept -> const EvtCounters& { return decoder.counters(); });
  }
  [[nodiscard]] EvtFormat format() const noexcept { return format_; }

 private:
  Evt2Decoder evt2_;
  Evt21Decoder evt21_;
  Evt3Decoder evt3_;
  EvtFormat format_;
};

}  // namespace egofocus
