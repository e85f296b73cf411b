// A camera on USB streams, stalls and drops without one allocation, lock or exception of ours.
#include <catch2/catch.hpp>

#include "inivation_stream.hpp"
#include "support/allocation_trap.hpp"
#include "usb_cameras.hpp"

using namespace scripted;

TEST_CASE("a started camera source allocates, locks and throws nothing while it streams") {
  if (!trapping()) return;
  Usb bus;
  bus.cameras = {davis346()};
  UsbCameraSettings settings;
  settings.imu = true;
  Bench bench(bus, settings);
  REQUIRE(bench.stream());
  auto& endings = bus.cameras[0].endings;
  endings.push_back({inivation::stream({inivation::time_reset(), inivation::time_stamp(1)}), 0});
  constexpr int kRounds = 500;
  for (int i = 0; i < kRounds; ++i) {
    Bytes bytes = inivation::stream({inivation::wrap(1), inivation::row(1)});
    for (unsigned k = 0; k < 1000; ++k) evt_words::append(bytes, inivation::column(1, k % 346), 2);
    inivation::append_imu(bytes, 0xE0, {1, 2, 3, 4, 5, 6, 7});
    endings.push_back({bytes, i % 50 == 7 ? EPIPE : i % 50 == 9 ? EOVERFLOW : 0});
  }
  const std::uint64_t before = bench.source.counters().transfers;
  arm();
  for (int i = 0; i < kRounds + 60; ++i) static_cast<void>(bench.source.poll(bench.inlets, 10'000));
  disarm();
  CHECK(allocations == 0);
  CHECK(releases == 0);
  CHECK(locks == 0);
  CHECK(exceptions == 0);
  const UsbCameraCounters counters = bench.source.counters();
  CHECK(counters.transfers - before >= kRounds);
  CHECK(counters.stalls == 10);
  CHECK(counters.events_pushed + counters.events_unmapped == 1000 * kRounds);
  CHECK(bench.rings.events.dropped() > 0);
}
