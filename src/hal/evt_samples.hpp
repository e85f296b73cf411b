// From the words of a live Prophesee sensor to events in the inlet, on the host's clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/source.hpp"
#include "hal/evt_decoder.hpp"
#include "hal/source_clock.hpp"

namespace egofocus {

struct EvtSampleCounters {
  std::uint64_t pushed = 0;    ///< offered to the ring, which counts what it drops
  std::uint64_t unmapped = 0;  ///< before device time could be mapped: dropped
  std::uint64_t clock_restarts = 0;
};

/// Decodes, maps device time to host time, pushes. Nothing is pushed before the clock's first pair, nor from
/// the batch in which device time was reset on. Thread: one. RT: take yes, O(bytes).
class EvtSamples {
 public:
  /// A sensor was started: decoder and clock begin anew, counts go on. `device_time`: its times are taken as
  /// they are.
  void restart(EvtFormat format, SensorSize size, bool device_time) noexcept {
    decoder_ = EvtDecoder(format, size, decoder_.counters());
    clock_.restart(device_time);
  }
  /// Bytes before the next ones were lost.
  void resync() noexcept { decoder_.resync(); }

  /// Bytes whose last word the host had at `host_us`. `is_whole`: no word goes on in the next ones.
  void take(std::span<const std::byte> bytes, std::int64_t host_us, bool is_whole, Inlets& inlets) noexcept {
    for (bool more = true; more;) {
      const std::uint64_t resets = evt()[EvtViolation::kTimeReset];
      const Decoded done = decoder_.feed(bytes, events_);
      bytes = bytes.subspan(done.consumed);
      more = done.produced == events_.size();
      if (evt()[EvtViolation::kTimeReset] != resets) {
        ++counters_.clock_restarts;
        clock_.restart();
      }
      push(std::span(events_).first(done.produced), inlets);
    }
    if (is_whole) decoder_.drop_partial();
    if (decoder_.is_time_known()) clock_.observe(decoder_.time_us(), host_us);
  }

  [[nodiscard]] std::int64_t watermark_us() const noexcept { return clock_.watermark_us(); }
  [[nodiscard]] const EvtCounters& evt() const noexcept { return decoder_.counters(); }
  [[nodiscard]] const EvtSampleCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] const ClockMap& clock() const noexcept { return clock_.map(); }

 private:
  void push(std::span<Event> events, Inlets& inlets) noexcept {
    if (!clock_.is_mapped()) {
      counters_.unmapped += events.size();
      return;
    }
    for (Event& event : events) event.t_us = clock_.to_host_us(event.t_us);
    inlets.push(std::span<const Event>(events));
    counters_.pushed += events.size();
  }

  EvtDecoder decoder_{EvtFormat::kEvt3, SensorSize{}};
  SourceClock clock_;
  EvtSampleCounters counters_;
  std::array<Event, 1024> events_;
};

}  // namespace egofocus
