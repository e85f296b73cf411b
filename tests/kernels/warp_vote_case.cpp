#include "warp_vote_case.hpp"

#include <algorithm>
#include <cmath>

namespace egofocus::test {
namespace {

constexpr std::int32_t kLimit = (1 << 30) - 1;
constexpr std::int32_t kSteepest = static_cast<std::int32_t>((2LL * kLimit) / 63);

std::int32_t between(std::mt19937& random, std::int64_t low, std::int64_t high) {
  return static_cast<std::int32_t>(
      low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1)));
}

}  // namespace

std::size_t WarpVoteCase::stack_bytes(const WarpVoteShape& s) {
  if (s.k_count == 0 || s.height == 0) return 0;
  const std::int64_t row = s.width + s.row_padding;
  const std::int64_t plane = row * s.height + s.plane_padding;
  return static_cast<std::size_t>((s.k_count - 1) * plane + (s.height - 1) * row + s.width);
}

WarpVoteCase::WarpVoteCase(const WarpVoteShape& shape, Fill fill, std::uint32_t seed)
    : shape_(shape),
      u_(static_cast<std::size_t>(shape.n)),
      v_(u_.size()),
      du_(u_.size()),
      dv_(u_.size()),
      k_end_(u_.size()),
      stack_(stack_bytes(shape)),
      scratch_(static_cast<std::size_t>(shape.width) * static_cast<std::size_t>(shape.height)),
      start_(stack_.size()) {
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < u_.size(); ++i) fill_event(i, fill, random);
  // Noise near saturation, so that a few votes reach it.
  for (std::uint8_t& byte : start_)
    byte = static_cast<std::uint8_t>(fill == Fill::kRandom ? random() : 250 + random() % 6);
}

void WarpVoteCase::fill_event(std::size_t i, Fill fill, std::mt19937& random) {
  const std::int64_t width = std::int64_t{shape_.width} << 16;
  const std::int64_t height = std::int64_t{shape_.height} << 16;
  const bool odd = i % 2 != 0;
  k_end_[i] = static_cast<std::uint8_t>(random() % 8 == 0 ? random() % 65 : 64);
  switch (fill) {
    case Fill::kRandom:  // in and around the grid, up to 1.5 px per hypothesis, both borders crossed
      u_[i] = between(random, -width / 4 - 65536, width + width / 4 + 65536);
      v_[i] = between(random, -height / 4 - 65536, height + height / 4 + 65536);
      du_[i] = between(random, -98304, 98304);
      dv_[i] = between(random, -98304, 98304);
      break;
    case Fill::kDense:  // exact halves and their neighbours, slow: long runs and ties
      u_[i] = between(random, -2, 2 * std::int64_t{shape_.width}) * 32768 + between(random, -1, 1);
      v_[i] = between(random, -2, 2 * std::int64_t{shape_.height}) * 32768 + between(random, -1, 1);
      du_[i] = between(random, -2, 2) * 8192;
      dv_[i] = between(random, -1, 1) * 4096;
      break;
    case Fill::kAllMin:
      u_[i] = v_[i] = -kLimit;
      du_[i] = dv_[i] = odd ? kSteepest : 0;
      break;
    case Fill::kAllMax:
      u_[i] = v_[i] = kLimit;
      du_[i] = dv_[i] = odd ? -kSteepest : 0;
      break;
    case Fill::kAlternating:  // from one end of the range to the other: across the grid between two
                              // hypotheses
      u_[i] = odd ? kLimit : -kLimit;
      du_[i] = odd ? -kSteepest : kSteepest;
      v_[i] = between(random, 0, std::max<std::int64_t>(height - 1, 0));
      dv_[i] = 0;
      break;
    case Fill::kOneCell:  // every vote on the last cell: saturation
      u_[i] = (shape_.width - 1) * 65536;
      v_[i] = (shape_.height - 1) * 65536;
      du_[i] = dv_[i] = 0;
      break;
  }
}

std::int64_t WarpVoteCase::run(WarpVoteFunction* function) {
  std::copy(start_.begin(), start_.end(), stack_.begin());
  WarpVote vote;
  vote.u_q16 = u_.data();
  vote.v_q16 = v_.data();
  vote.du_q16 = du_.data();
  vote.dv_q16 = dv_.data();
  vote.k_end = k_end_.data();
  vote.n = shape_.n;
  vote.k_begin = shape_.k_begin;
  vote.k_count = shape_.k_count;
  vote.width = shape_.width;
  vote.height = shape_.height;
  vote.row_stride = static_cast<std::int32_t>(row_stride());
  vote.plane_stride = plane_stride();
  vote.stack = stack_.data();
  vote.scratch = scratch_.data();
  return function(vote);
}

bool WarpVoteCase::scratch_is_zero() {
  return std::all_of(scratch_.begin(), scratch_.end(), [](std::uint32_t cell) { return cell == 0; });
}

std::int64_t WarpVoteCase::expect(std::vector<std::uint8_t>& stack) {
  std::vector<std::int64_t> counts(start_.begin(), start_.end());
  std::int64_t landed = 0;
  for (std::size_t i = 0; i < u_.size(); ++i) {
    const int last = std::min<int>(shape_.k_begin + shape_.k_count, k_end_[i]) - 1;
    for (int k = last; k >= shape_.k_begin; --k) {
      const double column = std::floor((u_[i] + static_cast<double>(k) * du_[i]) / 65536.0 + 0.5);
      const double row = std::floor((v_[i] + static_cast<double>(k) * dv_[i]) / 65536.0 + 0.5);
      if (!(column >= 0.0 && column <= shape_.width - 1.0 && row >= 0.0 && row <= shape_.height - 1.0))
        continue;
      const std::int64_t at = (k - shape_.k_begin) * plane_stride() +
                              static_cast<std::int64_t>(row) * row_stride() +
                              static_cast<std::int64_t>(column);
      ++counts.at(static_cast<std::size_t>(at));
      ++landed;
    }
  }
  stack.resize(counts.size());
  std::transform(counts.begin(), counts.end(), stack.begin(), [](std::int64_t count) {
    return static_cast<std::uint8_t>(std::min<std::int64_t>(count, 255));
  });
  return landed;
}

}  // namespace egofocus::test
