#include "kernels/conv_u8s8_neon_leave.inc"

namespace egofocus {
namespace {

/// A register of partial sums for each pixel and output: sixteen products are two multiplications into 16
/// bits (bytes up to 127: two products fit) and one pairwise addition into 32. Tiles of four outputs.
#if defined(__aarch64__)
inline int16x8_t products_16(int8x16_t x, int8x16_t w) noexcept {
  return vmlal_high_s8(vmull_s8(vget_low_s8(x), vget_low_s8(w)), x, w);
}

inline int32x4_t across(const int32x4_t* acc) noexcept {
  return vpaddq_s32(vpaddq_s32(acc[0], acc[1]), vpaddq_s32(acc[2], acc[3]));
}
#else
inline int16x8_t products_16(int8x16_t x, int8x16_t w) noexcept {
  return vmlal_s8(vmull_s8(vget_low_s8(x), vget_low_s8(w)), vget_high_s8(x), vget_high_s8(w));
}

inline int32x2_t halves(int32x4_t acc) noexcept {
  return vadd_s32(vget_low_s32(acc), vget_high_s32(acc));
}

inline int32x4_t across(const int32x4_t* acc) noexcept {
  return vcombine_s32(vpadd_s32(halves(acc[0]), halves(acc[1])), vpadd_s32(halves(acc[2]), halves(acc[3])));
}
#endif

template <int kPixels>
struct Sums {
  int32x4_t acc[kPixels][4];
};

template <int kPixels>
inline void add_8(Sums<kPixels>& sums, const int8x8_t* x, const std::int8_t* weights) noexcept {
  EGOFOCUS_UNROLL
  for (int o = 0; o < 4; ++o) {
    const int8x8_t w = vld1_s8(weights + 16 * o);
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) sums.acc[p][o] = vpadalq_s16(sums.acc[p][o], vmull_s8(x[p], w));
  }
}

/// Runs of eight inputs.
template <int kPixels>
inline void add_runs_of_8(Sums<kPixels>& sums, const ConvBlock& block, const std::int8_t* weights) noexcept {
  const std::int8_t* input[kPixels];
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) input[p] = with_sign(block.input + p * block.pixel_step);
  for (std::int32_t run = 0; run < block.runs->count; ++run) {
    const std::int64_t i = block.runs->offset[run];
    int8x8_t x[kPixels];
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) x[p] = vld1_s8(input[p] + i);
    add_8(sums, x, weights);
    weights += 64;
  }
}

template <int kPixels>
inline void add_runs(Sums<kPixels>& sums, const ConvBlock& block, const std::int8_t* weights) noexcept {
  const std::int8_t* input[kPixels];
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) input[p] = with_sign(block.input + p * block.pixel_step);
  for (std::int32_t run = 0; run < block.runs->count; ++run) {
    std::int64_t i = block.runs->offset[run];
    const std::int64_t end = i + block.runs->channels;
    const std::int64_t last = end - 16;
    for (; i <= last; i += 16) {
      int8x16_t x[kPixels];
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = vld1q_s8(input[p] + i);
      EGOFOCUS_UNROLL
      for (int o = 0; o < 4; ++o) {
        const int8x16_t w = vld1q_s8(weights + 16 * o);
        EGOFOCUS_UNROLL
        for (int p = 0; p < kPixels; ++p) sums.acc[p][o] = vpadalq_s16(sums.acc[p][o], products_16(x[p], w));
      }
      weights += 64;
    }
    if (i == end) continue;
    int8x8_t x[kPixels];
    if (end - i >= 8) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = vld1_s8(input[p] + i);
      add_8(sums, x, weights);
    }
    if ((end - i) % 8 != 0) {
      const std::int64_t first = end - 4 - i;  // 0 or 8
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = four_bytes(input[p] + i + first);
      add_8(sums, x, weights + first);
    }
    weights += 64;
  }
}

template <int kPixels, int kTiles>
void sums_of(const ConvBlock& block) noexcept {
  for (int t = 0; t < kTiles; ++t) {
    Sums<kPixels> sums;
    EGOFOCUS_UNROLL
    for (int o = 0; o < 4; ++o) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) sums.acc[p][o] = vdupq_n_s32(0);
    }
    const std::int8_t* weights = block.weights + t * block.tile_stride;
    if (block.runs->channels == 8) {
      add_runs_of_8(sums, block, weights);
    } else {
      add_runs(sums, block, weights);
    }
    const int32x4_t bias = vld1q_s32(block.bias + 4 * t);
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p)
      vst1q_s32(block.sums + 4 * (p * kTiles + t), vaddq_s32(across(sums.acc[p]), bias));
  }
}

template <int kPixels, int kTiles>
constexpr ConvBlockWidths widths() noexcept {
  return {kPixels,
          kPixels - 1,
          sums_of<kPixels, kTiles>,
          sums_of<kPixels - 1, kTiles>,
          sums_of<kPixels / 2, kTiles>,
          sums_of<1, kTiles>};
}

#if defined(__aarch64__)
constexpr int kMostPixels = 5;  // 32 registers
#else
constexpr int kMostPixels = 2;  // 16 registers
#endif
constexpr ConvBody kBody{
    kConvPacking_neon,
    4,
    4,
    {widths<kMostPixels, 1>(), widths<kMostPixels, 2>(), widths<kMostPixels, 3>(), widths<kMostPixels, 4>()},
    EGOFOCUS_LEAVE};

}  // namespace

void conv_u8s8_neon(const ConvU8S8& conv) noexcept {
  conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
