#include "pipeline/memory_plan.hpp"

#include "core/check.hpp"

namespace egofocus {

std::int32_t MemoryPlan::add(std::size_t bytes, int first_step, int last_step) noexcept {
  EGOFOCUS_CHECK(count_ < kMostBuffers && first_step <= last_step);
  Buffer& buffer = buffers_[count_];
  buffer.bytes = (bytes + Arena::kAlignment - 1) / Arena::kAlignment * Arena::kAlignment;
  buffer.first_step = first_step;
  buffer.last_step = last_step;
  return count_++;
}

// Candidates are 0 and the ends of those that are placed: the lowest one where nothing of the same time lies.
std::size_t MemoryPlan::lowest_fit(const Buffer& buffer) const noexcept {
  const auto free_at = [&](std::size_t at) noexcept {
    for (std::int32_t i = 0; i < count_; ++i) {
      const Buffer& other = buffers_[i];
      const bool same_time = other.first_step <= buffer.last_step && buffer.first_step <= other.last_step;
      const bool same_place = at < other.offset + other.bytes && other.offset < at + buffer.bytes;
      if (other.placed && same_time && same_place) return false;
    }
    return true;
  };
  std::size_t best = free_at(0) ? 0 : SIZE_MAX;
  for (std::int32_t i = 0; i < count_; ++i) {
    const std::size_t end = buffers_[i].offset + buffers_[i].bytes;
    if (buffers_[i].placed && end < best && free_at(end)) best = end;
  }
  return best;
}

void MemoryPlan::place(Arena& arena) noexcept {
  for (std::int32_t n = 0; n < count_; ++n) {
    Buffer* largest = nullptr;
    for (std::int32_t i = 0; i < count_; ++i) {
      Buffer& buffer = buffers_[i];
      if (!buffer.placed && (largest == nullptr || buffer.bytes > largest->bytes)) largest = &buffer;
    }
    largest->offset = lowest_fit(*largest);
    largest->placed = true;
    const std::size_t end = largest->offset + largest->bytes;
    if (end > total_) total_ = end;
  }
  block_ = arena.array<std::byte>(total_);
}

Arena MemoryPlan::arena(std::int32_t buffer) const noexcept {
  if (block_.empty()) return {};
  return Arena(block_.subspan(buffers_[buffer].offset, buffers_[buffer].bytes));
}

}  // namespace egofocus
