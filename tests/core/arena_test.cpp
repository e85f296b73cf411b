#include "core/arena.hpp"

#include <catch2/catch.hpp>

using namespace egofocus;

TEST_CASE("counting and handing out follow the same plan") {
  const auto plan = [](Arena& arena) {
    static_cast<void>(arena.array<std::uint8_t>(1));
    static_cast<void>(arena.array<std::uint64_t>(9));
    static_cast<void>(arena.object<int>(7));
  };
  Arena counter;
  plan(counter);
  CHECK(counter.used_bytes() == 64 + 128 + 64);
  alignas(64) std::byte block[256];
  Arena arena(block);
  plan(arena);
  CHECK(arena.used_bytes() == counter.used_bytes());
}

TEST_CASE("pieces are aligned, zeroed, apart, and end with the block") {
  alignas(64) std::byte block[192];
  for (auto& b : block) b = std::byte{0xff};
  Arena arena(block);
  const auto a = arena.array<std::uint32_t>(3);
  const auto b = arena.array<std::uint32_t>(3);
  REQUIRE(a.size() == 3);
  REQUIRE(b.size() == 3);
  CHECK(a[2] == 0);
  CHECK(reinterpret_cast<std::uintptr_t>(b.data()) % 64 == 0);
  CHECK(reinterpret_cast<std::byte*>(b.data()) - reinterpret_cast<std::byte*>(a.data()) == 64);
  CHECK(arena.array<std::uint8_t>(64).size() == 64);
  CHECK(arena.array<std::uint8_t>(1).empty());
  CHECK(arena.used_bytes() == 256);
}
