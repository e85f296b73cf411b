#include "kernels/conv_u8s8_neon_leave.inc"

namespace egofocus {
namespace {

/// Four outputs a register, one instruction for four inputs of each.
template <int kPixels, int kUnits>
struct Sums {
  int32x4_t acc[kPixels][kUnits];
};

template <int kLane, int kPixels, int kUnits>
inline void add_unit(Sums<kPixels, kUnits>& sums, int u, const int8x16_t* x,
                     const std::int8_t* weights) noexcept {
  const int8x16_t w = vld1q_s8(weights + 64 * kLane + 16 * u);
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) sums.acc[p][u] = vdotq_laneq_s32(sums.acc[p][u], w, x[p], kLane);
}

template <int kLane, int kPixels, int kUnits>
inline void add_group(Sums<kPixels, kUnits>& sums, const int8x16_t* x, const std::int8_t* weights) noexcept {
  EGOFOCUS_UNROLL
  for (int u = 0; u < kUnits; ++u) add_unit<kLane>(sums, u, x, weights);
}

template <int kPixels, int kUnits>
void sums_of(const ConvBlock& block) noexcept {
  Sums<kPixels, kUnits> sums;
  EGOFOCUS_UNROLL
  for (int u = 0; u < kUnits; ++u) {
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) sums.acc[p][u] = vld1q_s32(block.bias + 4 * u);
  }
  const std::int8_t* weights = block.weights;
  const std::int8_t* input[kPixels];
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) input[p] = with_sign(block.input + p * block.pixel_step);
  for (std::int32_t run = 0; run < block.runs->count; ++run) {
    std::int64_t i = block.runs->offset[run];
    const std::int64_t end = i + block.runs->channels;
    const std::int64_t last = end - 16;
    int8x16_t x[kPixels];
    for (; i <= last; i += 16) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = vld1q_s8(input[p] + i);
      EGOFOCUS_UNROLL
      for (int u = 0; u < kUnits; ++u) {  // few sums at a time, so that compilers keep all in registers
        add_unit<0>(sums, u, x, weights);
        add_unit<1>(sums, u, x, weights);
        add_unit<2>(sums, u, x, weights);
        add_unit<3>(sums, u, x, weights);
      }
      weights += 256;
    }
    if (end - i >= 8) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = vcombine_s8(vld1_s8(input[p] + i), vdup_n_s8(0));
      add_group<0>(sums, x, weights);
      add_group<1>(sums, x, weights);
      weights += 128;
      i += 8;
    }
    if (end - i >= 4) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = vcombine_s8(four_bytes(input[p] + i), vdup_n_s8(0));
      add_group<0>(sums, x, weights);
      weights += 64;
    }
  }
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) {
    EGOFOCUS_UNROLL
    for (int u = 0; u < kUnits; ++u) vst1q_s32(block.sums + 4 * (p * kUnits + u), sums.acc[p][u]);
  }
}

template <int kPixels, int kUnits>
constexpr ConvBlockWidths widths() noexcept {
  return {kPixels,
          kPixels - 1,
          sums_of<kPixels, kUnits>,
          sums_of<kPixels - 1, kUnits>,
          sums_of<kPixels / 2, kUnits>,
          sums_of<1, kUnits>};
}

// 32 registers: the sums, sixteen bytes of each pixel, a group's weights.
constexpr ConvBody kBody{kConvPacking_neondot,
                         4,
                         4,
                         {widths<8, 1>(), widths<8, 2>(), widths<7, 3>(), widths<6, 4>()},
                         EGOFOCUS_LEAVE};

}  // namespace

void conv_u8s8_neondot(const ConvU8S8& conv) noexcept {
  conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
