// A few samples that wait for their time, oldest first. Arrivals are nearly in order, so an insertion from
// the back moves next to nothing.
#pragma once

#include <cstdint>

#include "core/check.hpp"

namespace egofocus {

/// `Sample` has t_us. Equal times keep their order of arrival. Thread: one. RT: yes.
template <typename Sample, std::uint32_t kCapacity>
class SortBuffer {
  static_assert((kCapacity & (kCapacity - 1)) == 0);

 public:
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] bool full() const noexcept { return size_ == kCapacity; }
  /// Precondition: not empty.
  [[nodiscard]] const Sample& oldest() const noexcept { return slots_[first_]; }
  [[nodiscard]] bool due(std::int64_t t_us) const noexcept { return size_ > 0 && oldest().t_us <= t_us; }

  /// Precondition: not full.
  void insert(const Sample& sample) noexcept {
    EGOFOCUS_CHECK(!full());
    std::uint32_t i = size_++;
    for (; i > 0 && slot(i - 1).t_us > sample.t_us; --i) slot(i) = slot(i - 1);
    slot(i) = sample;
  }

  /// Precondition: not empty.
  Sample take_oldest() noexcept {
    EGOFOCUS_CHECK(!empty());
    const Sample sample = slots_[first_];
    first_ = (first_ + 1) & (kCapacity - 1);
    --size_;
    return sample;
  }

 private:
  Sample& slot(std::uint32_t i) noexcept { return slots_[(first_ + i) & (kCapacity - 1)]; }

  Sample slots_[kCapacity];
  std::uint32_t first_ = 0;
  std::uint32_t size_ = 0;
};

}  // namespace egofocus
