// One call of warp_vote with its memory: every array ends at an unmapped page, all bytes of the stack
// (padding too) start as noise, so that a byte changed anywhere shows.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "kernels/warp_vote.hpp"
#include "support/guarded_array.hpp"

namespace egofocus::test {

enum class Fill { kRandom, kDense, kAllMin, kAllMax, kAlternating, kOneCell };
inline constexpr Fill kEveryFill[] = {Fill::kRandom, Fill::kDense,       Fill::kAllMin,
                                      Fill::kAllMax, Fill::kAlternating, Fill::kOneCell};

struct WarpVoteShape {
  std::int32_t n;
  std::int32_t width;
  std::int32_t height;
  std::int32_t row_padding = 0;
  std::int32_t plane_padding = 0;
  std::int32_t k_begin = 0;
  std::int32_t k_count = 64;
};

class WarpVoteCase {
 public:
  WarpVoteCase(const WarpVoteShape& shape, Fill fill, std::uint32_t seed);

  const WarpVoteShape& shape() const { return shape_; }
  /// Runs on a fresh copy of the start values. What it left in the stack is stack().
  std::int64_t run(WarpVoteFunction* function);
  std::vector<std::uint8_t> stack() { return {stack_.begin(), stack_.end()}; }
  bool scratch_is_zero();
  /// The same by other means: positions in double, counts unbounded, saturated at the end.
  std::int64_t expect(std::vector<std::uint8_t>& stack);

 private:
  void fill_event(std::size_t i, Fill fill, std::mt19937& random);
  std::int64_t row_stride() const { return shape_.width + shape_.row_padding; }
  std::int64_t plane_stride() const { return row_stride() * shape_.height + shape_.plane_padding; }
  static std::size_t stack_bytes(const WarpVoteShape& shape);

  WarpVoteShape shape_;
  GuardedArray<std::int32_t> u_, v_, du_, dv_;
  GuardedArray<std::uint8_t> k_end_;
  GuardedArray<std::uint8_t> stack_;
  GuardedArray<std::uint32_t> scratch_;
  std::vector<std::uint8_t> start_;
};

}  // namespace egofocus::test
