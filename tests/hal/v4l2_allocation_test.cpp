// Between two marks nothing of this program may allocate: the stream of a V4L2 source, its losses included.
#include <atomic>
#include <cstdlib>
#include <new>

#include "hal/v4l2_bench.hpp"

namespace {

std::atomic<bool> armed{false};
std::atomic<long> allocations{0};

void* counted(std::size_t bytes) {
  if (armed.load(std::memory_order_relaxed)) allocations.fetch_add(1, std::memory_order_relaxed);
  void* const block = std::malloc(bytes);
  if (block == nullptr) std::abort();
  return block;
}

}  // namespace

void* operator new(std::size_t bytes) {
  return counted(bytes);
}
void* operator new[](std::size_t bytes) {
  return counted(bytes);
}
void operator delete(void* block) noexcept {
  std::free(block);
}
void operator delete[](void* block) noexcept {
  std::free(block);
}
void operator delete(void* block, std::size_t) noexcept {
  std::free(block);
}
void operator delete[](void* block, std::size_t) noexcept {
  std::free(block);
}

using namespace egofocus;

// The library calls no malloc either: tests/checks/symbols_allowed.txt.
TEST_CASE("V4L2: nothing is allocated after open(), whatever the buffers bring") {
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
  allocations = 0;
  armed = true;
  Delivery told;
  for (int i = 0; i < 300; ++i) told = bench.poll();
  armed = false;
  CHECK(allocations == 0);
  CHECK(told.status.ok());
  const V4l2CameraCounters counters = bench.source->counters();
  CHECK(counters.buffers == 1001);
  CHECK(counters.decoded + counters.damaged + counters.wrong + counters.unmarked_refused == 1001);
  CHECK(counters.damaged == 90);
  CHECK(bench.events().size() > 600);

  armed = true;
  const auto block = std::make_unique<int>(1);
  armed = false;
  CHECK(allocations == 1);  // the trap can fail
}
