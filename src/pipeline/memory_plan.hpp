// Where buffers lie that are not needed at the same time: lifetimes in, offsets out. Set-up only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/arena.hpp"

namespace egofocus {

/// Buffers that live from one step of a tick to another, both included. Two whose lives meet never overlap;
/// contents do not outlive them. Order of calls: add ... place, then bytes, arena.
class MemoryPlan {
 public:
  static constexpr std::int32_t kMostBuffers = 64;

  /// The buffer's number. Precondition: fewer than kMostBuffers so far; first_step <= last_step.
  std::int32_t add(std::size_t bytes, int first_step, int last_step) noexcept;

  /// Chooses the offsets (largest buffers first, each as low as it fits) and takes the block from the arena.
  void place(Arena& arena) noexcept;

  [[nodiscard]] std::size_t bytes() const noexcept { return total_; }
  [[nodiscard]] std::size_t offset(std::int32_t buffer) const noexcept { return buffers_[buffer].offset; }
  /// The buffer as an arena of its own; one that only counts when the plan's arena only counted.
  [[nodiscard]] Arena arena(std::int32_t buffer) const noexcept;

 private:
  struct Buffer {
    std::size_t bytes = 0;
    int first_step = 0;
    int last_step = 0;
    std::size_t offset = 0;
    bool placed = false;
  };
  [[nodiscard]] std::size_t lowest_fit(const Buffer& buffer) const noexcept;

  Buffer buffers_[kMostBuffers];
  std::int32_t count_ = 0;
  std::size_t total_ = 0;
  std::span<std::byte> block_;
};

}  // namespace egofocus
