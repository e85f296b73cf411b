// A V4L2 stream, with all that can be wrong with its buffers, without one allocation, lock or exception.
#include <catch2/catch.hpp>

#include "support/allocation_trap.hpp"
#include "v4l2_bench.hpp"

using namespace egofocus;

TEST_CASE("V4L2: a started source allocates, locks and throws nothing, whatever the buffers bring") {
  if (!trapping()) return;
  V4l2Bench bench;
  bench.disguise();
  bench.start_with_clock();
  bench.poll();
  for (std::uint32_t i = 1; i <= 1000; ++i) {
    auto& frame = bench.kernel.frame(evt3_event(i * 10, i, 5) + (i % 7 == 0 ? evt_words::Bytes{} : marker()));
    if (i % 11 == 0) frame.flags |= V4L2_BUF_FLAG_ERROR;
    if (i % 13 == 0) frame.used = 1'000'000;
    if (i % 17 == 0) frame.sequence += 2;
  }
  Delivery told;
  arm();
  for (int i = 0; i < 300; ++i) told = bench.poll();
  disarm();
  CHECK(allocations == 0);
  CHECK(locks == 0);
  CHECK(exceptions == 0);
  CHECK(told.status.ok());
  const V4l2CameraCounters counters = bench.source->counters();
  CHECK(counters.buffers == 1001);
  CHECK(counters.decoded + counters.damaged + counters.wrong + counters.unmarked_refused == 1001);
  CHECK(counters.damaged == 90);
  CHECK(bench.events().size() > 600);
}
