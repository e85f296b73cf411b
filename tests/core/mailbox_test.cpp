#include "core/mailbox.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

using namespace egofocus;

TEST_CASE("mailbox is empty at first, then gives the newest value") {
  Mailbox<int> box;
  CHECK(box.newest() == nullptr);
  for (int i = 1; i <= 3; ++i) {
    box.back() = i;
    box.publish();
  }
  REQUIRE(box.newest() != nullptr);
  CHECK(*box.newest() == 3);
  CHECK(*box.newest() == 3);
  box.back() = 4;
  box.publish();
  CHECK(*box.newest() == 4);
}

TEST_CASE("two threads: a value is never torn and never goes back") {
  struct Wide {
    std::uint64_t words[32] = {};
  };
  Mailbox<Wide> box;
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= 50000; ++i) {
      for (auto& word : box.back().words) word = i;
      box.publish();
    }
    done.store(true);
  });
  std::uint64_t last = 0;
  bool whole = true;
  bool forward = true;
  while (!done.load() || last != 50000) {
    const Wide* value = box.newest();
    if (value == nullptr) continue;
    for (auto word : value->words) whole &= word == value->words[0];
    forward &= value->words[0] >= last;
    last = value->words[0];
  }
  writer.join();
  CHECK(whole);
  CHECK(forward);
  CHECK(last == 50000);
}
