// A vote at a time, where other instruction sets take runs of them (warp_vote_runs.hpp): at about a pixel
// from one hypothesis to the next a run is hardly longer than a vote, and finding it costs more instructions
// than it saves. Where events land is found for a few of them first, in vectors; a byte each, then, is a
// load, an addition and a store.
#include <arm_neon.h>

#include <cstddef>

#include "kernels/warp_vote.hpp"

namespace egofocus {
namespace {

constexpr std::int32_t kGroup = 4;    // hypotheses that share the loads of an event
constexpr std::int32_t kEvents = 32;  // whose cells are found before the first of them is counted

inline int32x4_t load_bytes(const std::uint8_t* from) noexcept {
  std::uint32_t four = 0;
  __builtin_memcpy(&four, from, 4);
  const uint8x8_t bytes = vreinterpret_u8_u32(vdup_n_u32(four));
  return vreinterpretq_s32_u32(vmovl_u16(vget_low_u16(vmovl_u8(bytes))));
}

inline std::int32_t sum_of(uint32x4_t lanes) noexcept {
  const uint32x2_t halves = vadd_u32(vget_low_u32(lanes), vget_high_u32(lanes));
  return static_cast<std::int32_t>(vget_lane_u32(vpadd_u32(halves, halves), 0));
}

struct Frame {
  uint32x4_t width;
  uint32x4_t height;
  int32x4_t row_stride;
};

/// Where four events land in a plane, and -1 where they do not. One unsigned comparison checks both bounds.
inline int32x4_t cells_at(const Frame& frame, int32x4_t u, int32x4_t v, uint32x4_t votes,
                          uint32x4_t* landed) noexcept {
  const int32x4_t column = vshrq_n_s32(u, 16);
  const int32x4_t row = vshrq_n_s32(v, 16);
  const uint32x4_t inside = vandq_u32(vcltq_u32(vreinterpretq_u32_s32(column), frame.width),
                                      vcltq_u32(vreinterpretq_u32_s32(row), frame.height));
  const uint32x4_t lands = vandq_u32(inside, votes);
  *landed = vsubq_u32(*landed, lands);
  return vornq_s32(vmlaq_s32(column, row, frame.row_stride), vreinterpretq_s32_u32(lands));
}

inline void add_votes(const std::int32_t* cells, std::int32_t count, std::uint8_t* plane) noexcept {
  for (std::int32_t j = 0; j < count; j += 4) {
    // All four are loaded before the first store, which a compiler may take for one to them.
    const std::int32_t four[] = {cells[j], cells[j + 1], cells[j + 2], cells[j + 3]};
    for (const std::int32_t at : four) {
      if (at < 0) continue;
      const std::uint32_t sum = plane[at] + 1u;
      plane[at] = static_cast<std::uint8_t>(sum - (sum >> 8));  // saturated: 256 gives 255
    }
  }
}

/// Votes of the first `n` events, whole fours, for kPlanes hypotheses from k_first on.
template <std::int32_t kPlanes>
std::int32_t vote_group(const WarpVote& vote, std::int32_t n, std::int32_t k_first,
                        std::uint8_t* planes) noexcept {
  alignas(16) std::int32_t cells[static_cast<std::size_t>(kPlanes)][static_cast<std::size_t>(kEvents)];
  const Frame frame{vdupq_n_u32(static_cast<std::uint32_t>(vote.width)),
                    vdupq_n_u32(static_cast<std::uint32_t>(vote.height)), vdupq_n_s32(vote.row_stride)};
  const int32x4_t half = vdupq_n_s32(0x8000);
  uint32x4_t landed = vdupq_n_u32(0);
  for (std::int32_t first = 0; first < n; first += kEvents) {
    const std::int32_t count = n - first < kEvents ? n - first : kEvents;
    for (std::int32_t j = 0; j < count; j += 4) {
      const std::int32_t i = first + j;
      const int32x4_t du = vld1q_s32(vote.du_q16 + i);
      const int32x4_t dv = vld1q_s32(vote.dv_q16 + i);
      int32x4_t u = vmlaq_n_s32(vaddq_s32(vld1q_s32(vote.u_q16 + i), half), du, k_first);
      int32x4_t v = vmlaq_n_s32(vaddq_s32(vld1q_s32(vote.v_q16 + i), half), dv, k_first);
      const int32x4_t left = vsubq_s32(load_bytes(vote.k_end + i), vdupq_n_s32(k_first));
      for (std::int32_t h = 0; h < kPlanes; ++h) {
        vst1q_s32(&cells[h][j], cells_at(frame, u, v, vcgtq_s32(left, vdupq_n_s32(h)), &landed));
        u = vaddq_s32(u, du);
        v = vaddq_s32(v, dv);
      }
    }
    for (std::int32_t h = 0; h < kPlanes; ++h) add_votes(cells[h], count, planes + h * vote.plane_stride);
  }
  return sum_of(landed);
}

}  // namespace

std::int64_t warp_vote_u8_neon(const WarpVote& vote) noexcept {
  // A cell's place in its plane is an int32 here.
  if (std::int64_t{vote.height} * vote.row_stride > 0x7fffffff) return warp_vote_u8_scalar(vote);
  const std::int32_t whole = vote.n & ~3;
  std::int64_t landed = 0;
  for (std::int32_t plane = 0; plane < vote.k_count; plane += kGroup) {
    const std::int32_t k_first = vote.k_begin + plane;
    std::uint8_t* const planes = vote.stack + plane * vote.plane_stride;
    switch (vote.k_count - plane) {
      case 1:
        landed += vote_group<1>(vote, whole, k_first, planes);
        break;
      case 2:
        landed += vote_group<2>(vote, whole, k_first, planes);
        break;
      case 3:
        landed += vote_group<3>(vote, whole, k_first, planes);
        break;
      default:
        landed += vote_group<kGroup>(vote, whole, k_first, planes);
        break;
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
