// Newest-value mailbox: one writer, one reader, three slots. Neither ever waits; the reader always gets the
// newest complete value, older ones are overwritten.
//
// Proof. The three slot numbers {back, middle, front} are a permutation at all times: back belongs to the
// writer, front to the reader, middle to nobody. Each side changes owner only by one atomic exchange of
// `middle_`, so no slot has two owners. The exchange is acq_rel: what the writer wrote into a slot before
// handing it over is visible to the reader that takes it, and what the reader read is finished before the
// writer gets the slot back.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/layout.hpp"

namespace egofocus {

template <typename T>
class Mailbox {
 public:
  /// The slot to fill next. Thread: writer. RT: yes.
  T& back() noexcept { return slots_[back_]; }

  /// Makes back() the newest value. Thread: writer. RT: yes.
  void publish() noexcept {
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) & kSlot;
  }

  /// The newest value, or nullptr before the first. Valid until the next call. Thread: reader. RT: yes.
  const T* newest() noexcept {
    if (middle_.load(std::memory_order_relaxed) & kFresh) {
      front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kSlot;
      seen_ = true;
    }
    return seen_ ? &slots_[front_] : nullptr;
  }

  /// All three slots, for set-up. Thread: before both sides start.
  T* slots() noexcept { return slots_; }

 private:
  static constexpr std::uint8_t kFresh = 4;
  static constexpr std::uint8_t kSlot = 3;

  T slots_[3] = {};
  alignas(kCacheLine) std::uint8_t back_ = 0;  // the writer's
  alignas(kCacheLine) std::atomic<std::uint8_t> middle_{1};
  alignas(kCacheLine) std::uint8_t front_ = 2;  // the reader's
  bool seen_ = false;
};

}  // namespace egofocus
