#include "kernels/requant.hpp"
#include "requant_candidates.hpp"

namespace egofocus::bench {
namespace {

inline void store(std::uint8_t* to, const int32x4_t (&r)[4]) {
  const uint8x8_t low = vqmovun_s16(vcombine_s16(vqmovn_s32(r[0]), vqmovn_s32(r[1])));
  const uint8x8_t high = vqmovun_s16(vcombine_s16(vqmovn_s32(r[2]), vqmovn_s32(r[3])));
  vst1q_u8(to, vcombine_u8(low, high));
}

inline int32x4_t wide(int32x4_t acc, int32x4_t multiplier) {
  const int64x2_t down = vdupq_n_s64(-39);
  const int64x2_t low = vrshlq_s64(vmull_s32(vget_low_s32(acc), vget_low_s32(multiplier)), down);
  const int64x2_t high = vrshlq_s64(vmull_s32(vget_high_s32(acc), vget_high_s32(multiplier)), down);
  return vcombine_s32(vmovn_s64(low), vmovn_s64(high));
}

}  // namespace

void requant_wide_neon(const RequantLoad& w) noexcept {
  for (std::int32_t i = 0; i < w.n; i += 16) {
    int32x4_t r[4];
    for (int q = 0; q < 4; ++q)
      r[q] = wide(vld1q_s32(w.acc + i + 4 * q), vld1q_s32(w.multiplier + i + 4 * q));
    store(w.out + i, r);
  }
}

void requant_double_neon(const RequantLoad& w) noexcept {
  for (std::int32_t i = 0; i < w.n; i += 16) {
    int32x4_t r[4];
    for (int q = 0; q < 4; ++q) {
      const std::int32_t at = i + 4 * q;
      r[q] = vrshlq_s32(vqrdmulhq_s32(vld1q_s32(w.acc + at), vld1q_s32(w.multiplier + at)),
                        vld1q_s32(w.shift + at));
    }
    store(w.out + i, r);
  }
}

void requant_float_neon(const RequantLoad& w) noexcept {
  const int16x8_t zero = vdupq_n_s16(0);
  for (std::int32_t i = 0; i < w.n; i += 16) {
    int16x8_t s[2];
    for (int q = 0; q < 2; ++q) {
      const std::int32_t at = i + 8 * q;
      s[q] = requant_s16_neon(vld1q_s32(w.acc + at), vld1q_s32(w.acc + at + 4), vld1q_f32(w.scale + at),
                              vld1q_f32(w.scale + at + 4));
    }
    vst1q_u8(w.out + i, narrow_u8_neon(s[0], s[1], zero));
  }
}

void requant_narrow_neon(const RequantLoad& w) noexcept {
  for (std::int32_t i = 0; i < w.n; i += 16) {
    uint8x8_t s[2];
    for (int q = 0; q < 2; ++q) {
      const std::int32_t at = i + 8 * q;
      const int16x8_t acc =
          vcombine_s16(vqshrn_n_s32(vld1q_s32(w.acc + at), 4), vqshrn_n_s32(vld1q_s32(w.acc + at + 4), 4));
      s[q] = vqrshrun_n_s16(vqrdmulhq_s16(acc, vld1q_s16(w.multiplier16 + at)), 7);
    }
    vst1q_u8(w.out + i, vcombine_u8(s[0], s[1]));
  }
}

}  // namespace egofocus::bench
