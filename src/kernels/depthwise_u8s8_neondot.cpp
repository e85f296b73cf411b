#include "kernels/depthwise_u8s8_neon.inc"

namespace egofocus {
namespace {

/// Four rows are interleaved, a word for each channel: three rows of taps and a zero, a column of taps an
/// instruction for four channels.
template <int kRows>
struct ColumnsOfTaps {
  static constexpr DepthwisePacking kPacking = kDepthwisePacking_neondot;
  struct Column {
    int8x16_t low;
    int8x16_t high;
  };
  int8x16_t weights[kRows][3][2];

  EGOFOCUS_INLINE explicit ColumnsOfTaps(const std::int8_t* packed) noexcept {
    EGOFOCUS_UNROLL
    for (int at = 0; at < 6 * kRows; ++at) weights[at / 6][at % 6 / 2][at % 2] = vld1q_s8(packed + 16 * at);
  }

  static EGOFOCUS_INLINE int8x16_t interleave(int8x8_t a, int8x8_t b) noexcept {
    const int8x8_t none = vdup_n_s8(0);
    return vzip1q_s8(vcombine_s8(a, none), vcombine_s8(b, none));
  }

  static EGOFOCUS_INLINE Column column_of(const int8x8_t (&rows)[kRows + 2]) noexcept {
    const int16x8_t first = vreinterpretq_s16_s8(interleave(rows[0], rows[1]));
    const int16x8_t last = vreinterpretq_s16_s8(interleave(rows[2], rows[kRows + 1]));
    return {vreinterpretq_s8_s16(vzip1q_s16(first, last)), vreinterpretq_s8_s16(vzip2q_s16(first, last))};
  }

  EGOFOCUS_INLINE EightSums sums(int r, const EightSums& bias, const Column& a, const Column& b,
                                 const Column& c) const noexcept {
    EightSums acc = bias;
    const Column* const columns[3] = {&a, &b, &c};
    EGOFOCUS_UNROLL
    for (int kx = 0; kx < 3; ++kx) {
      acc.low = vdotq_s32(acc.low, columns[kx]->low, weights[r][kx][0]);
      acc.high = vdotq_s32(acc.high, columns[kx]->high, weights[r][kx][1]);
    }
    return acc;
  }
};

}  // namespace

void depthwise_u8s8_neondot(const DepthwiseU8S8& conv) noexcept {
  depthwise_by_strips<ColumnsOfTaps>(conv);
}

}  // namespace egofocus
