// One writer, any number of readers, the newest complete value: a sequence lock over relaxed atomic words.
//
// Proof. The writer makes the sequence odd, writes the words, makes it even. A reader takes the words between
// two loads of the same even sequence, else it tries again. Fences: the writer's release fence orders "odd"
// before the words and the release store orders the words before "even"; the reader's acquire load and
// acquire fence order its word loads between its two looks at the sequence. The words are atomics, so a torn
// read is a stale value, never a data race.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace egofocus {

template <typename T>
class Snapshot {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Thread: the writer. RT: yes, never waits.
  void publish(const T& value) noexcept {
    std::uint32_t words[kWords] = {};
    __builtin_memcpy(words, &value, sizeof(T));
    const std::uint32_t sequence = sequence_.load(std::memory_order_relaxed);
    sequence_.store(sequence + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_relaxed);
    sequence_.store(sequence + 2, std::memory_order_release);
  }

  /// Thread: any. RT: yes; false when a writer interfered kTries times in a row (then `value` is untouched).
  bool read(T& value) const noexcept {
    for (int i = 0; i < kTries; ++i) {
      const std::uint32_t before = sequence_.load(std::memory_order_acquire);
      if (before & 1) continue;
      std::uint32_t words[kWords];
      for (std::size_t w = 0; w < kWords; ++w) words[w] = words_[w].load(std::memory_order_relaxed);
      std::atomic_thread_fence(std::memory_order_acquire);
      if (sequence_.load(std::memory_order_relaxed) != before) continue;
      __builtin_memcpy(static_cast<void*>(&value), words, sizeof(T));
      return true;
    }
    return false;
  }

 private:
  static constexpr int kTries = 100000;
  static constexpr std::size_t kWords = (sizeof(T) + 3) / 4;
  std::atomic<std::uint32_t> sequence_{0};
  std::atomic<std::uint32_t> words_[kWords] = {};
};

}  // namespace egofocus
