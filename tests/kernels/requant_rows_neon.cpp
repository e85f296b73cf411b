#include "kernels/requant.hpp"
#include "requant_rows.hpp"

namespace egofocus::test {

void requant_rows_neon(const RequantArrays& a) {
  const int16x8_t zero = vdupq_n_s16(static_cast<std::int16_t>(a.zero));
  for (std::int32_t i = 0; i < a.n; i += 16) {
    const std::int32_t* acc = a.acc + i;
    const float* scale = a.scale + i;
    const int16x8_t low =
        requant_s16_neon(vld1q_s32(acc), vld1q_s32(acc + 4), vld1q_f32(scale), vld1q_f32(scale + 4));
    const int16x8_t high = requant_s16_neon(vld1q_s32(acc + 8), vld1q_s32(acc + 12), vld1q_f32(scale + 8),
                                            vld1q_f32(scale + 12));
    vst1q_s16(a.s16 + i, low);
    vst1q_s16(a.s16 + i + 8, high);
    vst1q_u8(a.u8 + i, narrow_u8_neon(low, high, zero));
    vst1q_s8(a.s8 + i, narrow_s8_neon(low, high, zero));
  }
}

}  // namespace egofocus::test
