#include "kernels/depthwise_u8s8_neon.inc"

namespace egofocus {
namespace {

/// A multiplication for eight channels and a tap; bytes up to 127: two products fit 16 bits.
template <int kRows>
struct PairsOfTaps {
  static constexpr DepthwisePacking kPacking = kDepthwisePacking_neon;
  struct Column {
    int8x8_t row[kRows + 2];
  };
  int8x8_t weights[9];  // column by column

  EGOFOCUS_INLINE explicit PairsOfTaps(const std::int8_t* packed) noexcept {
    EGOFOCUS_UNROLL
    for (int tap = 0; tap < 9; ++tap) weights[tap] = vld1_s8(packed + 8 * (tap % 3 * 3 + tap / 3));
  }

  static EGOFOCUS_INLINE Column column_of(const int8x8_t (&rows)[kRows + 2]) noexcept {
    Column column;
    EGOFOCUS_UNROLL
    for (int r = 0; r < kRows + 2; ++r) column.row[r] = rows[r];
    return column;
  }

  EGOFOCUS_INLINE EightSums sums(int r, const EightSums& bias, const Column& a, const Column& b,
                                 const Column& c) const noexcept {
    const int8x8_t x[9] = {a.row[r],     a.row[r + 1], a.row[r + 2], b.row[r],    b.row[r + 1],
                           b.row[r + 2], c.row[r],     c.row[r + 1], c.row[r + 2]};
    EightSums acc = bias;
    EGOFOCUS_UNROLL
    for (int tap = 0; tap < 9; tap += 2) {
      int16x8_t products = vmull_s8(x[tap], weights[tap]);
      if (tap < 8) products = vmlal_s8(products, x[tap + 1], weights[tap + 1]);
      acc.low = vaddw_s16(acc.low, vget_low_s16(products));
#if defined(__aarch64__)
      acc.high = vaddw_high_s16(acc.high, products);
#else
      acc.high = vaddw_s16(acc.high, vget_high_s16(products));
#endif
    }
    return acc;
  }
};

}  // namespace

void depthwise_u8s8_neon(const DepthwiseU8S8& conv) noexcept {
  depthwise_by_strips<PairsOfTaps>(conv);
}

}  // namespace egofocus
