// The one block of memory. A bump pointer, used twice with the same sequence of calls: without a block it
// only adds up (the exact number of bytes needed), with a block it hands out. Nothing is ever given back.
// Thread: set-up thread. RT: no (set-up only).
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "core/layout.hpp"

namespace egofocus {

/// What memory is for.
enum class ArenaPart : std::uint8_t { kEngine, kRings, kWindow, kMotion, kWarp, kBackend, kWeights, kDepth };
inline constexpr std::size_t kArenaParts = 8;

class Arena {
 public:
  static constexpr std::size_t kAlignment = kCacheLine;

  /// Counts only.
  Arena() noexcept = default;
  /// Hands out pieces of `block`, which starts at a multiple of kAlignment and has the counted size.
  explicit Arena(std::span<std::byte> block) noexcept : base_(block.data()), size_(block.size()) {}

  [[nodiscard]] bool counting() const noexcept { return base_ == nullptr; }
  [[nodiscard]] std::size_t used_bytes() const noexcept { return used_; }
  [[nodiscard]] std::size_t used_bytes(ArenaPart part) const noexcept {
    return part_bytes_[static_cast<std::size_t>(part)];
  }

  /// What is taken from here on counts to `part`; kEngine at first.
  Arena& part(ArenaPart part) noexcept {
    part_ = part;
    return *this;
  }

  /// `n` zero-initialised objects on their own cache lines; an empty span while counting.
  template <typename T>
  std::span<T> array(std::size_t n) noexcept {
    static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= kAlignment);
    std::byte* at = take(n <= SIZE_MAX / sizeof(T) ? n * sizeof(T) : SIZE_MAX);
    if (at == nullptr) return {};
    T* first = reinterpret_cast<T*>(at);
    for (std::size_t i = 0; i < n; ++i) new (static_cast<void*>(first + i)) T{};
    return {first, n};
  }

  /// One object; nullptr while counting.
  template <typename T, typename... Args>
  T* object(Args&&... args) noexcept {
    static_assert(alignof(T) <= kAlignment);
    std::byte* at = take(sizeof(T));
    return at == nullptr ? nullptr : new (static_cast<void*>(at)) T(std::forward<Args>(args)...);
  }

 private:
  std::byte* take(std::size_t bytes) noexcept {
    const std::size_t at = used_;
    const std::size_t most = SIZE_MAX / kAlignment * kAlignment;
    // More than the address space (32-bit machines): the sum sticks at the top, and no block is that large.
    if (bytes > most - at) {
      used_ = most;
      return nullptr;
    }
    used_ += (bytes + kAlignment - 1) / kAlignment * kAlignment;
    part_bytes_[static_cast<std::size_t>(part_)] += used_ - at;
    if (base_ == nullptr || used_ > size_) return nullptr;
    return base_ + at;
  }

  std::byte* base_ = nullptr;
  std::size_t size_ = 0;
  std::size_t used_ = 0;
  std::size_t part_bytes_[kArenaParts] = {};
  ArenaPart part_ = ArenaPart::kEngine;
};

}  // namespace egofocus
