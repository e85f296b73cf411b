// The block of an Arena, on the heap.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <span>

#include "core/arena.hpp"
#include "recording/error.hpp"

namespace egofocus::training {

/// `bytes`: what an Arena counted. Throws recording::Error (kInternal) when there is no memory.
class ArenaMemory {
 public:
  explicit ArenaMemory(std::size_t bytes)
      : bytes_(bytes), block_(std::aligned_alloc(Arena::kAlignment, bytes)) {
    if (!block_) throw recording::Error(recording::ExitCode::kInternal, "no memory for a window's stack");
  }
  [[nodiscard]] std::span<std::byte> span() const noexcept {
    return {static_cast<std::byte*>(block_.get()), bytes_};
  }

 private:
  struct Free {
    void operator()(void* block) const { std::free(block); }
  };
  std::size_t bytes_;
  std::unique_ptr<void, Free> block_;
};

}  // namespace egofocus::training
