// What the other side does in the middle of a copy, at a moment chosen by the test: a page that faults.
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstring>
#include <functional>
#include <vector>

#include "depth_memory.hpp"
#include "egofocus/depth_reader.h"

using namespace egofocus;
using daemon::DepthMemory;

namespace {

const Intrinsics kGrid{64, 64, 60, 60, 32, 32};
constexpr std::size_t kPixels = 64 * 64;
constexpr std::size_t kBytes = 2 * kPixels;  // two pages

// Two pages; the first touch of the second one calls `then`, once.
class TrapPages {
 public:
  TrapPages() {
    memory_ = ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    REQUIRE(memory_ != MAP_FAILED);
    REQUIRE(::sysconf(_SC_PAGESIZE) == static_cast<long>(kBytes / 2));
  }
  ~TrapPages() { ::munmap(memory_, kBytes); }

  std::uint16_t* pixels() { return static_cast<std::uint16_t*>(memory_); }

  void arm(std::function<void()> then) {
    armed = this;
    then_ = std::move(then);
    struct sigaction action {};
    action.sa_handler = [](int) { armed->spring(); };
    ::sigaction(SIGSEGV, &action, &before_);
    ::mprotect(static_cast<char*>(memory_) + kBytes / 2, kBytes / 2, PROT_NONE);
  }
  [[nodiscard]] bool sprung() const { return !then_; }

 private:
  void spring() {
    ::mprotect(memory_, kBytes, PROT_READ | PROT_WRITE);
    ::sigaction(SIGSEGV, &before_, nullptr);
    then_();
    then_ = nullptr;
  }
  static inline TrapPages* armed = nullptr;
  void* memory_ = nullptr;
  std::function<void()> then_;
  struct sigaction before_ {};
};

struct Source {
  const DepthFrame& frame(std::uint32_t n) {
    depth.assign(kPixels, static_cast<std::uint16_t>(n));
    frame_.grid = kGrid;
    frame_.t_us = n;
    frame_.inverse_depth = depth;
    frame_.confidence = confidence;
    return frame_;
  }
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> confidence = std::vector<std::uint8_t>(kPixels);
  DepthFrame frame_;
};

std::uint32_t lock_of(const DepthMemory& memory, std::uint32_t number, const egofocus_depth_reader& reader) {
  std::uint32_t lock = 0;
  std::memcpy(
      &lock,
      memory.memory() + reader.shape.header_bytes + number % reader.shape.slots * reader.shape.slot_bytes,
      sizeof lock);
  return lock;
}

}  // namespace

TEST_CASE("while a frame is written its slot says so, and the newest one is another") {
  DepthMemory memory(kGrid, 2);
  Source source;
  TrapPages pages;
  egofocus_depth_reader reader;
  REQUIRE(egofocus_depth_attach(&reader, memory.memory(), memory.bytes()) == 0);
  for (std::uint32_t n = 1; n <= 4; ++n) memory.publish(source.frame(n));
  DepthFrame frame = source.frame(5);
  frame.inverse_depth = {pages.pixels(), kPixels};
  std::uint32_t lock_meanwhile = 0;
  egofocus_depth_info seen{};
  int read = 0;
  pages.arm([&] {
    lock_meanwhile = lock_of(memory, 5, reader);
    read = egofocus_depth_newest(&reader, &seen, nullptr, nullptr);
  });
  memory.publish(frame);
  REQUIRE(pages.sprung());
  CHECK(lock_meanwhile % 2 == 1);
  CHECK(read == 1);
  CHECK(seen.t_us == 4);
  CHECK(lock_of(memory, 5, reader) == 10);
}

TEST_CASE("a frame that is overwritten while it is copied is not taken") {
  for (const std::uint32_t laps : {1u, 2u, 3u}) {
    DepthMemory memory(kGrid, 2);
    Source source;
    TrapPages pages;
    egofocus_depth_reader reader;
    REQUIRE(egofocus_depth_attach(&reader, memory.memory(), memory.bytes()) == 0);
    for (std::uint32_t n = 1; n <= 4; ++n) memory.publish(source.frame(n));
    pages.arm([&] {
      for (std::uint32_t n = 5; n <= 4 + 2 * laps; ++n) memory.publish(source.frame(n));
    });
    egofocus_depth_info info{};
    REQUIRE(egofocus_depth_newest(&reader, &info, pages.pixels(), nullptr) == 1);
    REQUIRE(pages.sprung());
    CHECK(info.t_us == 4 + 2 * laps);
    for (std::size_t i = 0; i < kPixels; ++i) REQUIRE(pages.pixels()[i] == info.t_us);
  }
}
