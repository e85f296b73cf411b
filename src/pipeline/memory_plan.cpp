#include "pipeline/memory_plan.hpp"

#include "core/check.hpp"

namespace egofocus {
namespace {

std::size_t whole_lines(std::size_t bytes) noexcept {
  return (bytes + Arena::kAlignment - 1) / Arena::kAlignment * Arena::kAlignment;
}

}  // namespace

std::int32_t MemoryPlan::add(std::size_t bytes, int first_step, int last_step) noexcept {
  return add(bytes, first_step, last_step, 0, last_step);
}

std::int32_t MemoryPlan::add(std::size_t bytes, int first_step, int last_step, std::size_t left,
                             int last_left) noexcept {
  EGOFOCUS_CHECK(count_ < kMostBuffers && first_step <= last_step && left <= bytes && last_step <= last_left);
  Buffer& buffer = buffers_[count_];
  buffer.bytes = whole_lines(bytes);
  buffer.first_step = first_step;
  buffer.last_step = last_step;
  buffer.left = whole_lines(left);
  buffer.last_left = last_left;
  return count_++;
}

// Whether `a` at `at` would lie, at some time, where b lies.
bool MemoryPlan::meet(const Buffer& a, std::size_t at, const Buffer& b) noexcept {
  const auto overlap = [&](std::size_t a_bytes, int a_first, int a_last, std::size_t b_bytes, int b_first,
                           int b_last) noexcept {
    return a_bytes > 0 && b_bytes > 0 && b_first <= a_last && a_first <= b_last && at < b.offset + b_bytes &&
           b.offset < at + a_bytes;
  };
  return overlap(a.bytes, a.first_step, a.last_step, b.bytes, b.first_step, b.last_step) ||
         overlap(a.bytes, a.first_step, a.last_step, b.left, b.last_step + 1, b.last_left) ||
         overlap(a.left, a.last_step + 1, a.last_left, b.bytes, b.first_step, b.last_step) ||
         overlap(a.left, a.last_step + 1, a.last_left, b.left, b.last_step + 1, b.last_left);
}

// Candidates are 0 and the ends of those that are placed, before and after they shrank: the lowest one where
// nothing of the same time lies.
std::size_t MemoryPlan::lowest_fit(const Buffer& buffer) const noexcept {
  std::size_t best = SIZE_MAX;
  const auto consider = [&](std::size_t at) noexcept {
    if (at >= best) return;
    for (std::int32_t i = 0; i < count_; ++i)
      if (buffers_[i].placed && meet(buffer, at, buffers_[i])) return;
    best = at;
  };
  consider(0);
  for (std::int32_t i = 0; i < count_; ++i) {
    if (!buffers_[i].placed) continue;
    consider(buffers_[i].offset + buffers_[i].bytes);
    if (buffers_[i].left > 0) consider(buffers_[i].offset + buffers_[i].left);
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

Arena MemoryPlan::arena(std::int32_t buffer, std::size_t from) const noexcept {
  EGOFOCUS_CHECK(from % Arena::kAlignment == 0 && from <= buffers_[buffer].bytes);
  if (block_.empty()) return {};
  return Arena(block_.subspan(buffers_[buffer].offset + from, buffers_[buffer].bytes - from));
}

}  // namespace egofocus
