#include <arm_neon.h>

#include "kernels/warp_vote_runs.hpp"

namespace egofocus {
namespace {

/// All lanes, ended or not: small ARM cores pay dearly for moving lane masks to general registers, and the
/// vector unit of the oldest has no permutation by a register pair in one step. keep_ended drops the rest.
inline void store_run(std::int32_t* to, int32x4_t run, uint32x4_t ended) noexcept {
  vst1q_s32(to, vbslq_s32(ended, run, vdupq_n_s32(kNoCell)));
}

/// count: a multiple of 4.
std::int32_t keep_ended(const std::int32_t* from, std::int32_t count, std::int32_t* to) noexcept {
  std::int64_t kept = 0;
  for (std::int32_t j = 0; j < count; j += 4) {
    for (std::int32_t i = j; i < j + 4; ++i) {
      const std::int64_t run = from[i];
      to[kept] = from[i];
      kept += 1 + (run >> 63);  // none where it is negative
    }
  }
  return static_cast<std::int32_t>(kept);
}

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

/// One lane is row << 16 | column: a single unsigned 16-bit minimum checks both bounds (negative ones wrap to
/// large).
struct Frame {
  uint16x8_t last;
  uint32x4_t width;
};

/// Where four events land, as a run's cell, and kNoCell where they do not.
inline int32x4_t cells_at(const Frame& frame, int32x4_t u, int32x4_t v, uint32x4_t votes,
                          uint32x4_t* landed) noexcept {
  // Shift right and insert: the row stays in the high half, the column comes into the low one.
  const uint32x4_t pixel = vsriq_n_u32(vreinterpretq_u32_s32(v), vreinterpretq_u32_s32(u), 16);
  const uint16x8_t halves = vreinterpretq_u16_u32(pixel);
  const uint32x4_t inside = vceqq_u32(vreinterpretq_u32_u16(vminq_u16(halves, frame.last)), pixel);
  const uint32x4_t lands = vandq_u32(inside, votes);
  *landed = vsubq_u32(*landed, lands);
  const uint32x4_t column = vandq_u32(pixel, vdupq_n_u32(0xffff));
  const uint32x4_t index = vmlaq_u32(column, vshrq_n_u32(pixel, 16), frame.width);
  return vbslq_s32(lands, vreinterpretq_s32_u32(vshlq_n_u32(index, 4)), vdupq_n_s32(kNoCell));
}

template <std::int32_t kPlanes>
FoundRuns find_runs_of(const WarpVote& vote, std::int32_t first, std::int32_t count, std::int32_t k_first,
                       std::int32_t* runs) noexcept {
  constexpr std::int32_t kEvents = 32;  // between two calls of keep_ended: candidates stay in the first cache
  alignas(16) std::int32_t candidates[kEvents * kPlanes];
  const Frame frame{vreinterpretq_u16_s32(vdupq_n_s32((vote.height - 1) << 16 | (vote.width - 1))),
                    vdupq_n_u32(static_cast<std::uint32_t>(vote.width))};
  const int32x4_t half = vdupq_n_s32(0x8000);
  const int32x4_t no_cell = vdupq_n_s32(kNoCell);
  const int32x4_t zero = vdupq_n_s32(0);
  uint32x4_t landed = vdupq_n_u32(0);
  std::int32_t found = 0;
  std::int32_t* candidate = candidates;
  for (std::int32_t i = first; i < first + count; i += 4) {
    const int32x4_t du = vld1q_s32(vote.du_q16 + i);
    const int32x4_t dv = vld1q_s32(vote.dv_q16 + i);
    int32x4_t u = vmlaq_n_s32(vaddq_s32(vld1q_s32(vote.u_q16 + i), half), du, k_first);
    int32x4_t v = vmlaq_n_s32(vaddq_s32(vld1q_s32(vote.v_q16 + i), half), dv, k_first);
    const int32x4_t left = vsubq_s32(load_bytes(vote.k_end + i), vdupq_n_s32(k_first));
    int32x4_t run = vorrq_s32(cells_at(frame, u, v, vcgtq_s32(left, zero), &landed), vdupq_n_s32(1));
    for (std::int32_t h = 1; h < kPlanes; ++h) {
      u = vaddq_s32(u, du);
      v = vaddq_s32(v, dv);
      const int32x4_t cell = cells_at(frame, u, v, vcgtq_s32(left, vdupq_n_s32(h)), &landed);
      const uint32x4_t stays = vceqq_s32(cell, vandq_s32(run, no_cell));
      store_run(candidate, run, vbicq_u32(vcgeq_s32(run, zero), stays));
      candidate += 4;
      run = vorrq_s32(vbslq_s32(stays, run, cell), vdupq_n_s32(1 << h));
    }
    store_run(candidate, run, vcgeq_s32(run, zero));
    candidate += 4;
    if ((i - first) % kEvents == kEvents - 4 || i + 4 == first + count) {
      found += keep_ended(candidates, static_cast<std::int32_t>(candidate - candidates), runs + found);
      candidate = candidates;
    }
  }
  return {found, sum_of(landed)};
}

FoundRuns find_runs(const WarpVote& vote, std::int32_t first, std::int32_t count, std::int32_t k_first,
                    std::int32_t planes, std::int32_t* runs) noexcept {
  switch (planes) {
    case 1:
      return find_runs_of<1>(vote, first, count, k_first, runs);
    case 2:
      return find_runs_of<2>(vote, first, count, k_first, runs);
    case 3:
      return find_runs_of<3>(vote, first, count, k_first, runs);
    default:
      return find_runs_of<4>(vote, first, count, k_first, runs);
  }
}

void add_runs(const std::int32_t* runs, std::int32_t count, std::uint32_t* scratch) noexcept {
  for (std::int32_t j = 0; j < count; ++j) {
    std::uint32_t* cell = scratch + (runs[j] >> 4);
    const uint8x8_t votes = vreinterpret_u8_u32(vld1_dup_u32(&kRunCounts[runs[j] & 15]));
    const uint8x8_t before = vreinterpret_u8_u32(vld1_dup_u32(cell));
    vst1_lane_u32(cell, vreinterpret_u32_u8(vqadd_u8(before, votes)), 0);
  }
}

void fold_row(std::uint32_t* cells, std::int32_t columns, std::uint8_t* row, std::int64_t plane_stride,
              std::int32_t planes) noexcept {
  const uint32x4_t zero = vdupq_n_u32(0);
  for (std::int32_t x = 0; x < columns; x += 16) {
    const uint8x16x4_t votes = vld4q_u8(reinterpret_cast<const std::uint8_t*>(cells + x));
    for (int q = 0; q < 4; ++q) vst1q_u32(cells + x + 4 * q, zero);
    for (std::int32_t h = 0; h < planes; ++h) {
      std::uint8_t* to = row + h * plane_stride + x;
      vst1q_u8(to, vqaddq_u8(vld1q_u8(to), votes.val[h]));
    }
  }
}

}  // namespace

std::int64_t warp_vote_u8_neon(const WarpVote& vote) noexcept {
  return warp_vote_by_runs(vote, {find_runs, add_runs, fold_row});
}

}  // namespace egofocus
