// The depth memory seen through the readers' header: order, what is lost, hostile headers, no torn frame.
#include "depth_memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>
#include <thread>
#include <vector>

#include "egofocus/depth_reader.h"
#include "support/arena_block.hpp"

using namespace egofocus;
using daemon::DepthMemory;

namespace {

const Intrinsics kGrid{37, 5, 30, 31, 18, 2};  // an odd number of pixels
constexpr std::size_t kPixels = 37 * 5;

// Every pixel of frame n says n.
class NumberedFrames {
 public:
  const DepthFrame& frame(std::uint32_t n) {
    frame_ = {};
    frame_.grid = kGrid;
    frame_.t_us = n;
    frame_.velocity_m_s[2] = n;
    frame_.flags = n;
    depth_.assign(kPixels, static_cast<std::uint16_t>(n));
    confidence_.assign(kPixels, static_cast<std::uint8_t>(n));
    frame_.inverse_depth = depth_;
    frame_.confidence = confidence_;
    return frame_;
  }

 private:
  DepthFrame frame_;
  std::vector<std::uint16_t> depth_;
  std::vector<std::uint8_t> confidence_;
};

struct Reader {
  explicit Reader(const DepthMemory& memory) {
    REQUIRE(egofocus_depth_attach(&reader, memory.memory(), memory.bytes()) == 0);
    REQUIRE(egofocus_depth_pixels(&reader) == kPixels);
  }
  int next() { return egofocus_depth_next(&reader, &info, depth, confidence); }
  int newest() { return egofocus_depth_newest(&reader, &info, depth, confidence); }
  // All of the frame says n.
  [[nodiscard]] bool is(std::int64_t n) const {
    bool same = info.t_us == n && info.velocity_m_s[2] == static_cast<double>(n) && info.flags == n;
    for (std::size_t i = 0; i < kPixels; ++i)
      same &= depth[i] == static_cast<std::uint16_t>(n) && confidence[i] == static_cast<std::uint8_t>(n);
    return same;
  }
  egofocus_depth_reader reader;
  egofocus_depth_info info;
  std::uint16_t depth[kPixels] = {};
  std::uint8_t confidence[kPixels] = {};
};

}  // namespace

TEST_CASE("frames come in order, the newest on request, and none twice") {
  DepthMemory memory(kGrid, 8);
  NumberedFrames frames;
  Reader reader(memory);
  CHECK(reader.next() == 0);
  CHECK(reader.newest() == 0);
  for (std::uint32_t n = 1; n <= 5; ++n) memory.publish(frames.frame(n));
  for (std::uint32_t n = 1; n <= 3; ++n) {
    REQUIRE(reader.next() == 1);
    CHECK(reader.is(n));
  }
  REQUIRE(reader.newest() == 1);
  CHECK(reader.is(5));
  CHECK(reader.newest() == 0);
  CHECK(reader.next() == 0);
  CHECK(reader.reader.missed == 0);  // frame 4 was left out by own choice
  CHECK(reader.info.width_px == 37);
  CHECK(reader.info.fy_px == 31);
}

TEST_CASE("a reader that sleeps finds the last slots - 1 frames, and knows how many it missed") {
  for (const std::uint32_t slots : {2u, 4u, 64u}) {
    DepthMemory memory(kGrid, slots);
    NumberedFrames frames;
    Reader reader(memory);
    memory.publish(frames.frame(1));
    REQUIRE(reader.next() == 1);
    for (std::uint32_t n = 2; n <= 200; ++n) memory.publish(frames.frame(n));
    for (std::uint32_t n = 200 - (slots - 1) + 1; n <= 200; ++n) {
      REQUIRE(reader.next() == 1);
      CHECK(reader.is(n));
    }
    CHECK(reader.next() == 0);
    CHECK(reader.reader.missed == 200 - (slots - 1) - 1);
  }
}

TEST_CASE("a writer that died within a frame leaves the others readable") {
  DepthMemory memory(kGrid, 4);
  NumberedFrames frames;
  for (std::uint32_t n = 1; n <= 6; ++n) memory.publish(frames.frame(n));
  Reader shape(memory);
  std::vector<std::byte> image(memory.memory(), memory.memory() + memory.bytes());
  const std::size_t slot = shape.reader.shape.header_bytes + (7 % 4) * shape.reader.shape.slot_bytes;
  const std::uint32_t in_work = 2 * 7 - 1;
  test::ArenaBlock block(image.size());
  std::memcpy(block.span().data(), image.data(), image.size());
  std::memcpy(block.span().data() + slot, &in_work, 4);
  std::memset(block.span().data() + slot + 64, 0xee, 300);
  Reader reader(memory);
  REQUIRE(egofocus_depth_attach(&reader.reader, block.span().data(), image.size()) == 0);
  for (std::uint32_t n = 4; n <= 6; ++n) {
    REQUIRE(reader.next() == 1);
    CHECK(reader.is(n));
  }
  CHECK(reader.next() == 0);
}

TEST_CASE("no reader ever gets a frame of two") {
  DepthMemory memory(kGrid, 2);
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    NumberedFrames frames;
    for (std::uint32_t n = 1; !stop.load(); ++n) {
      memory.publish(frames.frame(n));
      if (n % 8 == 0)
        std::this_thread::sleep_for(std::chrono::microseconds(20));  // else the reader never gets through
    }
  });
  Reader in_order(memory);
  Reader newest(memory);
  int got = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  for (int turn = 0; got < 1000 && std::chrono::steady_clock::now() < end; ++turn) {
    Reader& reader = turn % 2 == 0 ? in_order : newest;
    const std::int64_t before = reader.reader.last == 0 ? 0 : reader.info.t_us;
    const int result = turn % 2 == 0 ? reader.next() : reader.newest();
    if (result != 1) continue;
    ++got;
    if (!reader.is(reader.info.t_us) || reader.info.t_us <= before) {
      stop = true;
      writer.join();
      FAIL("torn or repeated frame " << reader.info.t_us << " after " << before);
    }
  }
  stop = true;
  writer.join();
  CHECK(got > 100);
}

TEST_CASE("who gets the descriptor can neither write nor shrink") {
  const DepthMemory memory(kGrid, 4);
  CHECK(::mmap(nullptr, memory.bytes(), PROT_READ | PROT_WRITE, MAP_SHARED, memory.descriptor(), 0) ==
        MAP_FAILED);
  CHECK(::ftruncate(memory.descriptor(), 64) != 0);
  CHECK(::ftruncate(memory.descriptor(), 1 << 20) != 0);
  const char byte = 'x';
  CHECK(::pwrite(memory.descriptor(), &byte, 1, 0) != 1);
  void* readable = ::mmap(nullptr, memory.bytes(), PROT_READ, MAP_SHARED, memory.descriptor(), 0);
  REQUIRE(readable != MAP_FAILED);
  CHECK(std::memcmp(readable, EGOFOCUS_DEPTH_MAGIC, 8) == 0);
  ::munmap(readable, memory.bytes());
}

TEST_CASE("memory whose header does not fit its size is refused") {
  const DepthMemory memory(kGrid, 4);
  test::ArenaBlock block(memory.bytes());
  egofocus_depth_reader reader;
  const auto refused = [&](std::size_t at, std::uint32_t value) {
    std::memcpy(block.span().data(), memory.memory(), memory.bytes());
    std::memcpy(block.span().data() + at, &value, sizeof value);
    return egofocus_depth_attach(&reader, block.span().data(), memory.bytes()) == -EPROTO &&
           reader.memory == nullptr;
  };
  using Header = egofocus_depth_header;
  CHECK(refused(0, 0));
  CHECK(refused(offsetof(Header, layout), 2));
  for (const std::uint32_t bad : {0u, 64u, 4096u * 64, 0xffffffc0u}) {
    INFO(bad);
    CHECK(refused(offsetof(Header, header_bytes), bad));
    CHECK(refused(offsetof(Header, inverse_depth_at), bad));
    CHECK(refused(offsetof(Header, confidence_at), bad));
  }
  for (const std::uint32_t bad : {0u, 1u, 3u, 8u, 128u, 0x80000000u})
    CHECK(refused(offsetof(Header, slots), bad));
  for (const std::uint32_t bad : {0u, 64u, 65u, 1u << 20, 0xffffffc0u})
    CHECK(refused(offsetof(Header, slot_bytes), bad));
  for (const std::uint32_t bad : {0u, 1000u, 4097u, 0xffffffffu}) {
    CHECK(refused(offsetof(Header, width_px), bad));
    CHECK(refused(offsetof(Header, height_px), bad));
  }
  CHECK(egofocus_depth_attach(&reader, memory.memory(), memory.bytes() - 1) == -EPROTO);
  CHECK(egofocus_depth_attach(&reader, memory.memory(), 0) == -EPROTO);
  CHECK(egofocus_depth_attach(&reader, memory.memory(), memory.bytes()) == 0);
}
