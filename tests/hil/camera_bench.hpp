// A camera's source on the real kernel, and what its stream must be.
#pragma once

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <vector>

#include "core/clock.hpp"
#include "core/inlets.hpp"
#include "hil/camera_time.hpp"
#include "hil/expect.hpp"

namespace egofocus::hil {

constexpr double kRate_hz = 20'000;  // of CountedEvents

inline void expect(bool condition, const char* what) {
  failures += !condition;
  std::printf("%s %s\n", condition ? "ok    " : "FAILED", what);
}

/// `Source`: a live camera's, made of its settings, its buffers and what else it needs.
template <typename Source>
struct CameraBench {
  template <typename Settings, typename... Rest>
  explicit CameraBench(const Settings& settings, Rest&&... rest)
      : buffers(Source::buffer_bytes(settings)), source(settings, buffers, rest...) {}
  std::vector<std::byte> buffers;
  std::vector<Event> event_slots = std::vector<Event>(1 << 16);
  std::vector<ImuSample> imu_slots = std::vector<ImuSample>(1 << 12);
  std::vector<OdometrySample> odometry_slots = std::vector<OdometrySample>(64);
  std::vector<PoseSample> pose_slots = std::vector<PoseSample>(64);
  Inlets::Rings rings{SpscRing<Event>(event_slots), SpscRing<ImuSample>(imu_slots),
                      SpscRing<OdometrySample>(odometry_slots), SpscRing<PoseSample>(pose_slots)};
  Inlets inlets{rings};
  Source source;
  std::int64_t longest_poll_us = 0;

  void poll() {
    const std::int64_t begin_us = host_us();
    static_cast<void>(source.poll(inlets, 10'000));
    longest_poll_us = std::max(longest_poll_us, host_us() - begin_us);
  }
  template <typename Take>
  void take_events(Take take) {
    for (auto some = rings.events.peek(1 << 16); !some.empty(); some = rings.events.peek(1 << 16)) {
      for (const Event& event : some) take(event);
      rings.events.release(some.size());
    }
  }
  /// Polls until an event has come; the time that it took, or -1 after `limit_us`.
  std::int64_t until_event(std::int64_t limit_us) {
    const std::int64_t begin_us = host_us();
    while (host_us() - begin_us < limit_us) {
      poll();
      if (rings.events.offered() == seen) continue;
      drop_events();
      return host_us() - begin_us;
    }
    return -1;
  }
  void drop_events() {
    take_events([](const Event&) {});
    rings.imu.release(rings.imu.peek(1 << 12).size());
    seen = rings.events.offered();
  }
  std::uint64_t seen = 0;
};

// One second of stream: nothing missing, nothing out of order, host times that are true.
template <typename Bench>
void check_stream(Bench& bench, int width_px, int height_px) {
  bench.drop_events();
  std::uint64_t events = 0;
  std::uint64_t gaps = 0;
  std::uint64_t backwards = 0;
  std::int64_t last = -1;
  std::int64_t last_us = 0;
  std::int64_t longest_age_us = 0;
  const std::int64_t begin_us = host_us();
  while (host_us() - begin_us < 1'000'000) {
    bench.poll();
    const std::int64_t at_us = host_us();
    bench.take_events([&](const Event& event) {
      const std::int64_t place = std::int64_t{event.y} * width_px + event.x;
      if (last >= 0 && place != (last + 1) % (std::int64_t{width_px} * height_px)) ++gaps;
      if (event.polarity != place % 2) ++gaps;
      if (event.t_us < last_us) ++backwards;
      longest_age_us = std::max(longest_age_us, at_us - event.t_us);
      last = place;
      last_us = event.t_us;
      ++events;
    });
  }
  const double seconds = static_cast<double>(host_us() - begin_us) / 1e6;
  std::printf("       %" PRIu64 " events in %.2f s, %" PRIu64 " gaps, oldest on arrival %" PRId64
              " us, longest poll %" PRId64 " us\n",
              events, seconds, gaps, longest_age_us, bench.longest_poll_us);
  expect(static_cast<double>(events) > 0.8 * kRate_hz, "events come at the camera's rate");
  expect(gaps == 0, "no event is missing");
  expect(backwards == 0, "times never go back");
  expect(longest_age_us < 500'000, "host times are near the host's clock");
}

}  // namespace egofocus::hil
