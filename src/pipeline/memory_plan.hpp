// Where buffers lie that are not needed at the same time: lifetimes in, offsets out. Set-up only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/arena.hpp"

namespace egofocus {

/// Buffers that live from one step of a tick to another, both included; of some the first bytes live longer.
/// What lives at the same time never overlaps; contents do not outlive it. Order of calls: add ... place,
/// then bytes, arena.
class MemoryPlan {
 public:
  static constexpr std::int32_t kMostBuffers = 64;

  /// The buffer's number. Precondition: fewer than kMostBuffers so far; first_step <= last_step.
  std::int32_t add(std::size_t bytes, int first_step, int last_step) noexcept;
  /// One that shrinks to `left` bytes after last_step, and lives so until last_left. Precondition: left <=
  /// bytes, last_step < last_left.
  std::int32_t add(std::size_t bytes, int first_step, int last_step, std::size_t left,
                   int last_left) noexcept;

  /// Chooses the offsets (largest buffers first, each as low as it fits) and takes the block from the arena.
  void place(Arena& arena) noexcept;

  [[nodiscard]] std::size_t bytes() const noexcept { return total_; }
  [[nodiscard]] std::size_t offset(std::int32_t buffer) const noexcept { return buffers_[buffer].offset; }
  /// The buffer as an arena of its own; one that only counts when the plan's arena only counted.
  [[nodiscard]] Arena arena(std::int32_t buffer) const noexcept { return arena(buffer, 0); }
  /// The same from a byte of it on, a multiple of Arena::kAlignment: for what shares it in its own order.
  [[nodiscard]] Arena arena(std::int32_t buffer, std::size_t from) const noexcept;

 private:
  struct Buffer {
    std::size_t bytes = 0;
    int first_step = 0;
    int last_step = 0;
    std::size_t left = 0;  // bytes from last_step + 1 to last_left
    int last_left = 0;
    std::size_t offset = 0;
    bool placed = false;
  };
  static bool meet(const Buffer& a, std::size_t at, const Buffer& b) noexcept;
  [[nodiscard]] std::size_t lowest_fit(const Buffer& buffer) const noexcept;

  Buffer buffers_[kMostBuffers];
  std::int32_t count_ = 0;
  std::size_t total_ = 0;
  std::span<std::byte> block_;
};

}  // namespace egofocus
