#include "core/ring.hpp"

#include <catch2/catch.hpp>
#include <thread>
#include <vector>

using namespace egofocus;

TEST_CASE("ring gives back what was pushed, in order, over many wraps") {
  std::vector<std::uint32_t> storage(8);
  SpscRing<std::uint32_t> ring(storage);
  std::uint32_t next_in = 0;
  std::uint32_t next_out = 0;
  for (int round = 0; round < 1000; ++round) {
    const std::size_t n = static_cast<std::size_t>(round % 7) + 1;
    std::vector<std::uint32_t> batch(n);
    for (auto& v : batch) v = next_in++;
    REQUIRE(ring.push(batch) == n);
    while (true) {
      const auto ready = ring.peek(3);
      if (ready.empty()) break;
      for (std::uint32_t v : ready) REQUIRE(v == next_out++);
      ring.release(ready.size());
    }
  }
  CHECK(next_in == next_out);
  CHECK(ring.dropped() == 0);
}

TEST_CASE("a full ring takes what fits and counts the rest") {
  std::vector<int> storage(4);
  SpscRing<int> ring(storage);
  const int batch[] = {1, 2, 3, 4, 5, 6};
  CHECK(ring.push(batch) == 4);
  CHECK(ring.offered() == 6);
  CHECK(ring.dropped() == 2);
  CHECK(ring.room() == 0);
  CHECK(ring.claim(1).empty());
  CHECK(ring.peek(10).size() == 4);
  ring.release(1);
  CHECK(ring.room() == 1);
  CHECK(ring.peek(10).front() == 2);
}

TEST_CASE("claim and peek never cross the end of the storage") {
  std::vector<int> storage(8);
  SpscRing<int> ring(storage);
  const int six[] = {0, 1, 2, 3, 4, 5};
  CHECK(ring.push(six) == 6);
  ring.release(ring.peek(6).size());
  CHECK(ring.claim(8).size() == 2);  // slots 6 and 7, then the storage ends
  ring.commit(2);
  CHECK(ring.claim(8).size() == 6);
}

TEST_CASE("two threads: every item arrives once, in order, or is counted as dropped") {
  std::vector<std::uint64_t> storage(64);
  SpscRing<std::uint64_t> ring(storage);
  constexpr std::uint64_t kItems = 200000;
  std::thread producer([&] {
    std::uint64_t batch[5];
    for (std::uint64_t i = 0; i < kItems;) {
      std::size_t n = 0;
      while (n < 5 && i < kItems) batch[n++] = i++;
      ring.push(std::span<const std::uint64_t>(batch, n));
      if (i % 1000 == 0) std::this_thread::yield();
    }
  });
  std::uint64_t received = 0;
  std::uint64_t last = 0;
  bool ordered = true;
  const auto drain = [&] {
    const auto ready = ring.peek(16);
    for (std::uint64_t v : ready) {
      ordered &= received == 0 || v > last;
      last = v;
      ++received;
    }
    ring.release(ready.size());
    return !ready.empty();
  };
  while (ring.offered() < kItems) drain();
  producer.join();
  while (drain()) {
  }
  CHECK(ordered);
  CHECK(received + ring.dropped() == kItems);
  CHECK(ring.offered() == kItems);
}
