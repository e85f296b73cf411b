#include "kernels/warp_vote_runs.hpp"

namespace egofocus {
namespace {

constexpr std::int32_t whole_lanes(std::int32_t n) noexcept {
  return n & ~(kVoteLane - 1);
}
constexpr std::int32_t smaller(std::int32_t a, std::int32_t b) noexcept {
  return a < b ? a : b;
}

void fold_columns(std::uint32_t* cells, std::int32_t columns, std::uint8_t* row, std::int64_t plane_stride,
                  std::int32_t planes) noexcept {
  for (std::int32_t x = 0; x < columns; ++x) {
    for (std::int32_t h = 0; h < planes; ++h) {
      std::uint8_t& count = row[h * plane_stride + x];
      const std::uint32_t sum = count + ((cells[x] >> (8 * h)) & 0xffu);
      count = static_cast<std::uint8_t>(sum < 255 ? sum : 255);
    }
    cells[x] = 0;
  }
}

void fold_group(const WarpVote& vote, const VoteSteps& steps, std::uint8_t* planes_begin,
                std::int32_t planes) noexcept {
  const std::int32_t whole = whole_lanes(vote.width);
  for (std::int32_t y = 0; y < vote.height; ++y) {
    std::uint32_t* cells = vote.scratch + y * vote.width;
    std::uint8_t* row = planes_begin + static_cast<std::int64_t>(y) * vote.row_stride;
    steps.fold_row(cells, whole, row, vote.plane_stride, planes);
    fold_columns(cells + whole, vote.width - whole, row + whole, vote.plane_stride, planes);
  }
}

}  // namespace

std::int64_t warp_vote_by_runs(const WarpVote& vote, const VoteSteps& steps) noexcept {
  if (vote.scratch == nullptr) return warp_vote_u8_scalar(vote);
  if (vote.width == 0 || vote.height == 0) return 0;

  const std::int32_t whole = whole_lanes(vote.n);
  std::int64_t landed = 0;
  if (whole > 0) {
    alignas(64) std::int32_t runs[kRunRoom];
    for (std::int32_t plane = 0; plane < vote.k_count; plane += kVoteGroup) {
      const std::int32_t planes = smaller(kVoteGroup, vote.k_count - plane);
      for (std::int32_t first = 0; first < whole; first += kVoteBlock) {
        const std::int32_t count = smaller(kVoteBlock, whole - first);
        const FoundRuns found = steps.find_runs(vote, first, count, vote.k_begin + plane, planes, runs);
        steps.add_runs(runs, found.runs, vote.scratch);
        landed += found.landed;
      }
      fold_group(vote, steps, vote.stack + plane * vote.plane_stride, planes);
    }
  }

  WarpVote rest = vote;
  rest.u_q16 += whole;
  rest.v_q16 += whole;
  rest.du_q16 += whole;
  rest.dv_q16 += whole;
  rest.k_end += whole;
  rest.n -= whole;
  return landed + warp_vote_u8_scalar(rest);
}

}  // namespace egofocus
