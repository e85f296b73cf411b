// How sums leave on NEON: shared by the three bodies of conv_u8s8 for ARM.
#pragma once

#include <arm_neon.h>

#include "kernels/conv_u8s8_blocks.hpp"
#include "kernels/requant.hpp"

namespace egofocus {
namespace {

inline void store_part(std::uint8_t* to, uint8x8_t bytes, std::int32_t count) noexcept {
  if (count == 4) {
    const std::uint32_t four = vget_lane_u32(vreinterpret_u32_u8(bytes), 0);
    __builtin_memcpy(to, &four, 4);
    return;
  }
  std::uint8_t all[8];
  vst1_u8(all, bytes);
  for (std::int32_t i = 0; i < count; ++i) to[i] = all[i];
}

inline uint8x8_t load_part(const std::uint8_t* from, std::int32_t count) noexcept {
  std::uint8_t all[8] = {};
  for (std::int32_t i = 0; i < count; ++i) all[i] = from[i];
  return vld1_u8(all);
}

/// Eight outputs of one pixel, or, in the last ones of a layer, `count` of them.
template <ConvEpilogue kEpilogue, bool kWhole>
inline void leave_8(int16x8_t r, const std::uint8_t* addend, std::uint8_t* out, std::int32_t count) noexcept {
  if constexpr (kEpilogue == ConvEpilogue::kScore) {
    const uint8x16_t bytes = vreinterpretq_u8_s16(r);
    if constexpr (kWhole) return vst1q_u8(out, bytes);
    if (count == 1) return vst1q_lane_s16(reinterpret_cast<std::int16_t*>(out), r, 0);
    store_part(out, vget_low_u8(bytes), count < 4 ? 2 * count : 8);
    if (count > 4) store_part(out + 8, vget_high_u8(bytes), 2 * count - 8);
  } else {
    uint8x8_t bytes;
    if constexpr (kEpilogue == ConvEpilogue::kSmall) {
      bytes = vreinterpret_u8_s8(vqmovn_s16(r));
    } else {
      int16x8_t sum = r;
      if constexpr (kEpilogue == ConvEpilogue::kAdd) {
        const uint8x8_t x = kWhole ? vld1_u8(addend) : load_part(addend, count);
        sum = vqaddq_s16(r, vreinterpretq_s16_u16(vmovl_u8(x)));
      }
      bytes = vmin_u8(vqmovun_s16(sum), vdup_n_u8(127));
    }
    if constexpr (kWhole) return vst1_u8(out, bytes);
    store_part(out, bytes, count);
  }
}

template <ConvEpilogue kEpilogue, bool kWhole>
inline void leave_column(const ConvLeaving& leaving, std::int32_t o, std::int32_t count) noexcept {
  constexpr std::int32_t kElement = kEpilogue == ConvEpilogue::kScore ? 2 : 1;
  const bool second = o + 4 < leaving.row;  // a lone unit of four has no other half
  const float32x4_t scale0 = vld1q_f32(leaving.scale + o);
  const float32x4_t scale1 = kWhole || second ? vld1q_f32(leaving.scale + o + 4) : scale0;
  const std::int32_t* sums = leaving.sums + o;
  const std::uint8_t* addend = kEpilogue == ConvEpilogue::kAdd ? leaving.addend + o : nullptr;
  std::uint8_t* out = leaving.output + kElement * o;
  for (std::int32_t p = 0; p < leaving.pixels; ++p) {
    const int32x4_t acc0 = vld1q_s32(sums);
    const int32x4_t acc1 = kWhole || second ? vld1q_s32(sums + 4) : acc0;
    leave_8<kEpilogue, kWhole>(requant_s16_neon(acc0, acc1, scale0, scale1), addend, out, count);
    sums += leaving.row;
    out += leaving.output_step;
    if constexpr (kEpilogue == ConvEpilogue::kAdd) addend += leaving.addend_step;
  }
}

/// Sixteen outputs of each pixel.
template <ConvEpilogue kEpilogue>
inline void leave_wide_column(const ConvLeaving& leaving, std::int32_t o, std::int64_t row) noexcept {
  constexpr std::int32_t kElement = kEpilogue == ConvEpilogue::kScore ? 2 : 1;
  float32x4_t scale[4];
  for (int q = 0; q < 4; ++q) scale[q] = vld1q_f32(leaving.scale + o + 4 * q);
  const std::int32_t* sums = leaving.sums + o;
  const std::uint8_t* addend = kEpilogue == ConvEpilogue::kAdd ? leaving.addend + o : nullptr;
  std::uint8_t* out = leaving.output + kElement * o;
  const std::int32_t* end = sums + leaving.pixels * row;
  const std::int64_t step = leaving.output_step;
  while (sums != end) {
    int16x8_t low = requant_s16_neon(vld1q_s32(sums), vld1q_s32(sums + 4), scale[0], scale[1]);
    int16x8_t high = requant_s16_neon(vld1q_s32(sums + 8), vld1q_s32(sums + 12), scale[2], scale[3]);
    if constexpr (kEpilogue == ConvEpilogue::kScore) {
      vst1q_s16(reinterpret_cast<std::int16_t*>(out), low);
      vst1q_s16(reinterpret_cast<std::int16_t*>(out) + 8, high);
    } else if constexpr (kEpilogue == ConvEpilogue::kSmall) {
      vst1q_u8(out, vreinterpretq_u8_s8(vcombine_s8(vqmovn_s16(low), vqmovn_s16(high))));
    } else {
      if constexpr (kEpilogue == ConvEpilogue::kAdd) {
        const uint8x16_t x = vld1q_u8(addend);
        low = vqaddq_s16(low, vreinterpretq_s16_u16(vmovl_u8(vget_low_u8(x))));
        high = vqaddq_s16(high, vreinterpretq_s16_u16(vmovl_u8(vget_high_u8(x))));
        addend += leaving.addend_step;
      }
      const uint8x16_t bytes = vcombine_u8(vqmovun_s16(low), vqmovun_s16(high));
      vst1q_u8(out, vminq_u8(bytes, vdupq_n_u8(127)));
    }
    sums += row;
    out += step;
  }
}

template <ConvEpilogue kEpilogue>
void leave_as(const ConvLeaving& leaving) noexcept {
  std::int32_t o = 0;
  if (leaving.outputs == 16 && leaving.row == 16) return leave_wide_column<kEpilogue>(leaving, 0, 16);
  for (; o + 16 <= leaving.outputs; o += 16) leave_wide_column<kEpilogue>(leaving, o, leaving.row);
  for (; o + 8 <= leaving.outputs; o += 8) leave_column<kEpilogue, true>(leaving, o, 8);
  if (o < leaving.outputs) leave_column<kEpilogue, false>(leaving, o, leaving.outputs - o);
}

/// Bytes up to 127 are the same number with a sign.
inline const std::int8_t* with_sign(const std::uint8_t* bytes) noexcept {
  return reinterpret_cast<const std::int8_t*>(bytes);
}

inline int8x8_t four_bytes(const std::int8_t* from) noexcept {  // zeros above
  std::uint32_t four = 0;
  __builtin_memcpy(&four, from, 4);
  return vcreate_s8(four);
}

}  // namespace
}  // namespace egofocus
