#include "kernels/conv_u8s8_neon_leave.hpp"

namespace egofocus {
namespace {

/// Two pixels by two outputs a register, one instruction for eight inputs. Tiles of eight outputs. Of an odd
/// number of pixels the last stands in for its neighbour.
template <int kPixels, int kTiles>
struct Sums {
  static constexpr int kPairs = (kPixels + 1) / 2;
  int32x4_t acc[kPairs][4 * kTiles];
};

template <int kPixels, int kTiles>
inline void add_group(Sums<kPixels, kTiles>& sums, const int8x16_t* pairs, const std::int8_t* weights,
                      std::int64_t tile_stride) noexcept {
  EGOFOCUS_UNROLL
  for (int o = 0; o < 4 * kTiles; ++o) {
    const int8x16_t w = vld1q_s8(weights + o / 4 * tile_stride + 16 * (o % 4));
    EGOFOCUS_UNROLL
    for (int p = 0; p < Sums<kPixels, kTiles>::kPairs; ++p)
      sums.acc[p][o] = vmmlaq_s32(sums.acc[p][o], pairs[p], w);
  }
}

inline int8x16_t join(int8x16_t a, int8x16_t b, bool high) noexcept {
  const int64x2_t a2 = vreinterpretq_s64_s8(a);
  const int64x2_t b2 = vreinterpretq_s64_s8(b);
  return vreinterpretq_s8_s64(high ? vtrn2q_s64(a2, b2) : vtrn1q_s64(a2, b2));
}

template <int kPixels, int kTiles>
void sums_of(const ConvBlock& block) noexcept {
  constexpr int kPairs = Sums<kPixels, kTiles>::kPairs;
  Sums<kPixels, kTiles> sums;
  EGOFOCUS_UNROLL
  for (int o = 0; o < 4 * kTiles; ++o) {
    const int32x2_t bias = vld1_s32(block.bias + 2 * o);
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPairs; ++p) sums.acc[p][o] = vcombine_s32(bias, bias);
  }
  const std::int8_t* weights = block.weights;
  const std::int64_t stride = block.tile_stride;
  for (std::int32_t run = 0; run < block.runs->count; ++run) {
    const std::int8_t* input[2 * kPairs];
    EGOFOCUS_UNROLL
    for (int p = 0; p < 2 * kPairs; ++p) {
      const int pixel = p < kPixels ? p : kPixels - 1;
      input[p] = with_sign(block.input + block.runs->offset[run] + pixel * block.pixel_step);
    }
    const std::int64_t channels = block.runs->channels;
    std::int64_t i = 0;
    int8x16_t low[kPairs];
    for (; i + 16 <= channels; i += 16) {
      int8x16_t high[kPairs];
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p) {
        const int8x16_t first = vld1q_s8(input[2 * p] + i);
        const int8x16_t second = vld1q_s8(input[2 * p + 1] + i);
        low[p] = join(first, second, false);
        high[p] = join(first, second, true);
      }
      add_group<kPixels, kTiles>(sums, low, weights, stride);
      add_group<kPixels, kTiles>(sums, high, weights + 64, stride);
      weights += 128;
    }
    if (channels - i >= 8) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p)
        low[p] = vcombine_s8(vld1_s8(input[2 * p] + i), vld1_s8(input[2 * p + 1] + i));
      add_group<kPixels, kTiles>(sums, low, weights, stride);
      weights += 64;
      i += 8;
    }
    if (channels - i >= 4) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p)
        low[p] = vcombine_s8(four_bytes(input[2 * p] + i), four_bytes(input[2 * p + 1] + i));
      add_group<kPixels, kTiles>(sums, low, weights, stride);
      weights += 64;
    }
  }
  EGOFOCUS_UNROLL
  for (int p = 0; p < kPixels; ++p) {
    EGOFOCUS_UNROLL
    for (int o = 0; o < 4 * kTiles; o += 2) {
      const int8x16_t a = vreinterpretq_s8_s32(sums.acc[p / 2][o]);
      const int8x16_t b = vreinterpretq_s8_s32(sums.acc[p / 2][o + 1]);
      vst1q_s32(block.sums + 8 * kTiles * p + 2 * o, vreinterpretq_s32_s8(join(a, b, p % 2 != 0)));
    }
  }
}

template <int kPixels, int kTiles>
constexpr ConvBlockWidths widths() noexcept {
  return {kPixels, sums_of<kPixels, kTiles>, sums_of<kPixels - 1, kTiles>, sums_of<kPixels / 2, kTiles>,
          sums_of<1, kTiles>};
}

// 32 registers: the sums, eight bytes of each pixel twice, two outputs' weights.
constexpr ConvBody kBody{kConvPacking_neonmm, 2, {widths<10, 1>(), widths<6, 2>()}, leave};

}  // namespace

void conv_u8s8_neonmm(const ConvU8S8& conv) noexcept {
  conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
