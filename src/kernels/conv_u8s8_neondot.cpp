#include "kernels/conv_u8s8_neon_leave.hpp"

namespace egofocus {
namespace {

/// Four outputs a register, one instruction for four inputs of each.
template <int kPixels, int kTiles>
struct Sums {
  int32x4_t acc[kPixels][kTiles];
};

template <int kLane, int kPixels, int kTiles>
inline void add_group(Sums<kPixels, kTiles>& sums, const int8x16_t* x, const std::int8_t* weights,
                      std::int64_t tile_stride) noexcept {
  int8x16_t w[kTiles];
  EGOFOCUS_UNROLL
  for (int t = 0; t < kTiles; ++t) w[t] = vld1q_s8(weights + t * tile_stride + 16 * kLane);
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) {
    EGOFOCUS_UNROLL
    for (int t = 0; t < kTiles; ++t) sums.acc[p][t] = vdotq_laneq_s32(sums.acc[p][t], w[t], x[p], kLane);
  }
}

template <int kPixels, int kTiles>
void sums_of(const ConvBlock& block) noexcept {
  Sums<kPixels, kTiles> sums;
  EGOFOCUS_UNROLL
  for (int t = 0; t < kTiles; ++t) {
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) sums.acc[p][t] = vld1q_s32(block.bias + 4 * t);
  }
  const std::int8_t* weights = block.weights;
  const std::int64_t stride = block.tile_stride;
  for (std::int32_t run = 0; run < block.runs->count; ++run) {
    const std::int8_t* input[kPixels];
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p)
      input[p] = with_sign(block.input + block.runs->offset[run] + p * block.pixel_step);
    int8x16_t x[kPixels];
    const std::int64_t channels = block.runs->channels;
    std::int64_t i = 0;
    for (; i + 16 <= channels; i += 16) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = vld1q_s8(input[p] + i);
      add_group<0>(sums, x, weights, stride);
      add_group<1>(sums, x, weights, stride);
      add_group<2>(sums, x, weights, stride);
      add_group<3>(sums, x, weights, stride);
      weights += 64;
    }
    if (channels - i >= 8) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = vcombine_s8(vld1_s8(input[p] + i), vdup_n_s8(0));
      add_group<0>(sums, x, weights, stride);
      add_group<1>(sums, x, weights, stride);
      weights += 32;
      i += 8;
    }
    if (channels - i >= 4) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = vcombine_s8(four_bytes(input[p] + i), vdup_n_s8(0));
      add_group<0>(sums, x, weights, stride);
      weights += 16;
    }
  }
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) {
    EGOFOCUS_UNROLL
    for (int t = 0; t < kTiles; ++t) vst1q_s32(block.sums + 4 * (p * kTiles + t), sums.acc[p][t]);
  }
}

template <int kPixels, int kTiles>
constexpr ConvBlockWidths widths() noexcept {
  return {kPixels, sums_of<kPixels, kTiles>, sums_of<kPixels - 1, kTiles>, sums_of<kPixels / 2, kTiles>,
          sums_of<1, kTiles>};
}

// 32 registers: the sums, sixteen bytes of each pixel, a group's weights.
constexpr ConvBody kBody{kConvPacking_neondot, 2, {widths<8, 1>(), widths<8, 2>()}, leave};

}  // namespace

void conv_u8s8_neondot(const ConvU8S8& conv) noexcept {
  conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
