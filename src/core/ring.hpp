// Single-producer single-consumer ring: lock-free and wait-free, batch claim and commit, counts what it
// drops.
//
// Order proof. `head_` is written by the producer alone, `tail_` by the consumer alone; both count items
// since the beginning and wrap only after 2^32 items modulo arithmetic that stays exact because capacity <=
// 2^31.
//  - The producer writes slots [head, head + n) and then stores head + n with release. The consumer loads
//  head with
//    acquire, so it sees those writes: a slot is read only after it was written.
//  - The consumer finishes reading slots [tail, tail + n) and then stores tail + n with release. The producer
//  loads
//    tail with acquire before it writes a slot again: a slot is overwritten only after it was read.
//  - head - tail is never above capacity: the producer claims at most capacity - (head - tail_seen), and
//  tail_seen
//    is never ahead of the true tail.
// Each side keeps a cached copy of the other's index on its own cache line, and looks at the shared one only
// when the cached one no longer suffices: in steady state no cache line bounces per item.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "core/check.hpp"
#include "core/layout.hpp"

namespace egofocus {

template <typename T>
class SpscRing {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// `storage` has a power-of-two size <= 2^31 and outlives the ring. An empty one makes a ring that must not
  /// be used (the arena's counting run).
  explicit SpscRing(std::span<T> storage) noexcept
      : slots_(storage.data()), mask_(static_cast<std::uint32_t>(storage.size()) - 1) {
    EGOFOCUS_CHECK((storage.size() & (storage.size() - 1)) == 0);
  }
  SpscRing(const SpscRing&) = delete;
  SpscRing& operator=(const SpscRing&) = delete;

  [[nodiscard]] std::uint32_t capacity() const noexcept { return mask_ + 1; }

  // --- producer
  // ---------------------------------------------------------------------------------------------------

  /// Up to `wanted` free slots in one piece; may be fewer at the end of the storage or when the ring fills
  /// up. Thread: producer. RT: yes.
  std::span<T> claim(std::size_t wanted) noexcept {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    std::uint32_t free = capacity() - (head - tail_seen_);
    if (free < wanted) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      free = capacity() - (head - tail_seen_);
    }
    const std::uint32_t at = head & mask_;
    const std::uint32_t contiguous = capacity() - at;
    std::size_t n = wanted < free ? wanted : free;
    if (n > contiguous) n = contiguous;
    return {slots_ + at, n};
  }

  /// Publishes the first n slots of the last claim. Thread: producer. RT: yes.
  void commit(std::size_t n) noexcept {
    head_.store(head_.load(std::memory_order_relaxed) + static_cast<std::uint32_t>(n),
                std::memory_order_release);
  }

  /// Copies what fits, in order, and counts the rest as dropped. Returns the number taken. Thread: producer.
  /// RT: yes.
  std::size_t push(std::span<const T> items) noexcept {
    std::size_t done = 0;
    while (done < items.size()) {
      const std::span<T> room = claim(items.size() - done);
      if (room.empty()) break;
      for (std::size_t i = 0; i < room.size(); ++i) room[i] = items[done + i];
      commit(room.size());
      done += room.size();
    }
    count(offered_, items.size());
    if (done < items.size()) count(dropped_, items.size() - done);
    return done;
  }

  /// Slots that are surely free now. Thread: producer. RT: yes.
  [[nodiscard]] std::size_t room() noexcept {
    tail_seen_ = tail_.load(std::memory_order_acquire);
    return capacity() - (head_.load(std::memory_order_relaxed) - tail_seen_);
  }

  // --- consumer
  // ---------------------------------------------------------------------------------------------------

  /// The oldest items in one piece, at most `wanted`, without taking them. Thread: consumer. RT: yes.
  std::span<const T> peek(std::size_t wanted) noexcept {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    std::uint32_t ready = head_seen_ - tail;
    if (ready < wanted) {
      head_seen_ = head_.load(std::memory_order_acquire);
      ready = head_seen_ - tail;
    }
    const std::uint32_t at = tail & mask_;
    const std::uint32_t contiguous = capacity() - at;
    std::size_t n = wanted < ready ? wanted : ready;
    if (n > contiguous) n = contiguous;
    return {slots_ + at, n};
  }

  /// Gives back the first n peeked slots. Thread: consumer. RT: yes.
  void release(std::size_t n) noexcept {
    tail_.store(tail_.load(std::memory_order_relaxed) + static_cast<std::uint32_t>(n),
                std::memory_order_release);
  }

  // --- any thread
  // -------------------------------------------------------------------------------------------------

  [[nodiscard]] std::uint64_t offered() const noexcept { return offered_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  // One writer: a plain load and store is enough, and cheaper than an atomic addition.
  static void count(std::atomic<std::uint64_t>& counter, std::uint64_t n) noexcept {
    counter.store(counter.load(std::memory_order_relaxed) + n, std::memory_order_relaxed);
  }

  // Read-only after construction.
  alignas(kCacheLine) T* slots_;
  std::uint32_t mask_;
  // The producer's line.
  alignas(kCacheLine) std::atomic<std::uint32_t> head_{0};
  std::uint32_t tail_seen_ = 0;
  std::atomic<std::uint64_t> offered_{0};
  std::atomic<std::uint64_t> dropped_{0};
  // The consumer's line.
  alignas(kCacheLine) std::atomic<std::uint32_t> tail_{0};
  std::uint32_t head_seen_ = 0;
};

}  // namespace egofocus
