// One writer, two readers: what is read is one published value, whole, and never older than the one before.
// The thread sanitizer runs this test too.
#include "core/snapshot.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <thread>

using namespace egofocus;

namespace {

struct Value {
  std::uint64_t number = 0;
  std::uint64_t copies[37] = {};
  std::uint8_t tail = 0;  // a size that is no multiple of a word
};

Value make(std::uint64_t n) {
  Value value;
  value.number = n;
  for (std::size_t i = 0; i < 37; ++i) value.copies[i] = n * 0x9e3779b97f4a7c15u + i;
  value.tail = static_cast<std::uint8_t>(n);
  return value;
}

bool whole(const Value& value) {
  const Value truth = make(value.number);
  for (std::size_t i = 0; i < 37; ++i) {
    if (value.copies[i] != truth.copies[i]) return false;
  }
  return value.tail == truth.tail;
}

}  // namespace

TEST_CASE("a snapshot is zero before the first value and the newest one afterwards") {
  auto snapshot = std::make_unique<Snapshot<Value>>();
  Value value = make(3);
  REQUIRE(snapshot->read(value));
  CHECK(value.number == 0);
  snapshot->publish(make(7));
  snapshot->publish(make(8));
  REQUIRE(snapshot->read(value));
  CHECK(value.number == 8);
  CHECK(whole(value));
}

TEST_CASE("two readers never see a torn snapshot, nor time going back") {
  auto snapshot = std::make_unique<Snapshot<Value>>();
  snapshot->publish(make(1));
  constexpr std::uint64_t kLast = 20'000;
  std::atomic<std::uint64_t> torn{0};
  std::atomic<std::uint64_t> back{0};
  std::atomic<int> ready{0};
  const auto reader = [&] {
    std::uint64_t newest = 0;
    Value value;
    ready.fetch_add(1);
    while (newest < kLast) {
      if (!snapshot->read(value)) continue;
      if (!whole(value)) torn.fetch_add(1);
      if (value.number < newest) back.fetch_add(1);
      newest = value.number;
    }
  };
  std::thread a(reader);
  std::thread b(reader);
  while (ready.load() < 2) std::this_thread::yield();
  for (std::uint64_t n = 2; n <= kLast; ++n) {
    snapshot->publish(make(n));
    if (n % 64 == 0) std::this_thread::yield();
  }
  a.join();
  b.join();
  CHECK(torn.load() == 0);
  CHECK(back.load() == 0);
}
