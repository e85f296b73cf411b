// Memory for an Arena in tests: aligned, freed at the end, and filled with a pattern so that nobody can rely
// on fresh pages being zero.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <span>

#include "core/arena.hpp"

namespace egofocus::test {

class ArenaBlock {
 public:
  explicit ArenaBlock(std::size_t bytes) : memory_(new std::byte[bytes + Arena::kAlignment]), bytes_(bytes) {
    std::memset(memory_.get(), 0xa5, bytes + Arena::kAlignment);
  }

  [[nodiscard]] std::span<std::byte> span() const noexcept {
    const auto address = reinterpret_cast<std::uintptr_t>(memory_.get());
    const std::size_t skip = (Arena::kAlignment - address % Arena::kAlignment) % Arena::kAlignment;
    return {memory_.get() + skip, bytes_};
  }

 private:
  std::unique_ptr<std::byte[]> memory_;
  std::size_t bytes_;
};

/// An arena that is large enough for one piece under test.
class RoomyArena {
 public:
  explicit RoomyArena(std::size_t bytes = std::size_t{1} << 24) : block_(bytes), arena_(block_.span()) {}
  Arena& operator*() noexcept { return arena_; }

 private:
  ArenaBlock block_;
  Arena arena_;
};

}  // namespace egofocus::test
