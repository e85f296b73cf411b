#include "kernels/conv_u8s8_neon_leave.inc"

namespace egofocus {
namespace {

/// Two pixels by two outputs a register, one instruction for eight inputs. Of an odd
/// number of pixels the last stands in for its neighbour.
template <int kPixels, int kUnits>
struct Sums {
  static constexpr int kPairs = (kPixels + 1) / 2;
  int32x4_t acc[kPairs][2 * kUnits];
};

/// Two outputs' eight inputs.
template <int kPixels, int kUnits>
inline void add_pair(Sums<kPixels, kUnits>& sums, int o, const int8x16_t* pairs,
                     const std::int8_t* weights) noexcept {
  const int8x16_t w = vld1q_s8(weights + 16 * o);
  EGOFOCUS_UNROLL
  for (int p = 0; p < Sums<kPixels, kUnits>::kPairs; ++p)
    sums.acc[p][o] = vmmlaq_s32(sums.acc[p][o], pairs[p], w);
}

template <int kPixels, int kUnits>
inline void add_group(Sums<kPixels, kUnits>& sums, const int8x16_t* pairs,
                      const std::int8_t* weights) noexcept {
  EGOFOCUS_UNROLL
  for (int o = 0; o < 2 * kUnits; ++o) add_pair(sums, o, pairs, weights);
}

inline int8x16_t join(int8x16_t a, int8x16_t b, bool high) noexcept {
  const int64x2_t a2 = vreinterpretq_s64_s8(a);
  const int64x2_t b2 = vreinterpretq_s64_s8(b);
  return vreinterpretq_s8_s64(high ? vtrn2q_s64(a2, b2) : vtrn1q_s64(a2, b2));
}

template <int kPixels, int kUnits>
void sums_of(const ConvBlock& block) noexcept {
  constexpr int kPairs = Sums<kPixels, kUnits>::kPairs;
  Sums<kPixels, kUnits> sums;
  EGOFOCUS_UNROLL
  for (int o = 0; o < 2 * kUnits; ++o) {
    const int32x2_t bias = vld1_s32(block.bias + 2 * o);
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPairs; ++p) sums.acc[p][o] = vcombine_s32(bias, bias);
  }
  const std::int8_t* weights = block.weights;
  const std::int8_t* input[2 * kPairs];
  EGOFOCUS_UNROLL
  for (int p = 0; p < 2 * kPairs; ++p) {
    const int pixel = p < kPixels ? p : kPixels - 1;
    input[p] = with_sign(block.input + pixel * block.pixel_step);
  }
  for (std::int32_t run = 0; run < block.runs->count; ++run) {
    std::int64_t i = block.runs->offset[run];
    const std::int64_t end = i + block.runs->channels;
    const std::int64_t last = end - 16;
    int8x16_t low[kPairs];
    for (; i <= last; i += 16) {
      int8x16_t high[kPairs];
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p) {
        const int8x16_t first = vld1q_s8(input[2 * p] + i);
        const int8x16_t second = vld1q_s8(input[2 * p + 1] + i);
        low[p] = join(first, second, false);
        high[p] = join(first, second, true);
      }
      EGOFOCUS_UNROLL
      for (int o = 0; o < 2 * kUnits; ++o) {  // few sums at a time, so that compilers keep all in registers
        add_pair(sums, o, low, weights);
        add_pair(sums, o, high, weights + 128);
      }
      weights += 256;
    }
    if (end - i >= 8) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p)
        low[p] = vcombine_s8(vld1_s8(input[2 * p] + i), vld1_s8(input[2 * p + 1] + i));
      add_group<kPixels, kUnits>(sums, low, weights);
      weights += 128;
      i += 8;
    }
    if (end - i >= 4) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p)
        low[p] = vcombine_s8(four_bytes(input[2 * p] + i), four_bytes(input[2 * p + 1] + i));
      add_group<kPixels, kUnits>(sums, low, weights);
      weights += 128;
    }
  }
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) {
    EGOFOCUS_UNROLL
    for (int o = 0; o < 2 * kUnits; o += 2) {
      const int8x16_t a = vreinterpretq_s8_s32(sums.acc[p / 2][o]);
      const int8x16_t b = vreinterpretq_s8_s32(sums.acc[p / 2][o + 1]);
      vst1q_s32(block.sums + 4 * kUnits * p + 2 * o, vreinterpretq_s32_s8(join(a, b, p % 2 != 0)));
    }
  }
}

template <int kPixels, int kUnits>
constexpr ConvBlockWidths widths() noexcept {
  return {kPixels,
          kPixels - 2,
          sums_of<kPixels, kUnits>,
          sums_of<kPixels - 2, kUnits>,
          sums_of<kPixels / 2, kUnits>,
          sums_of<1, kUnits>};
}

// 32 registers: the sums, eight bytes of each pixel twice, two outputs' weights.
constexpr ConvBody kBody{kConvPacking_neonmm,
                         4,
                         4,
                         {widths<8, 1>(), widths<8, 2>(), widths<6, 3>(), widths<6, 4>()},
                         EGOFOCUS_LEAVE};

}  // namespace

void conv_u8s8_neonmm(const ConvU8S8& conv) noexcept {
  conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
