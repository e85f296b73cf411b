#include "kernels/conv_u8s8_neon.inc"

namespace egofocus {
namespace {

/// The lane is a constant wherever this stands.
EGOFOCUS_INLINE int32x4_t dot_lane(int32x4_t acc, int8x16_t weights, int8x16_t x, int lane) noexcept {
  if (lane == 0) return vdotq_laneq_s32(acc, weights, x, 0);
  if (lane == 1) return vdotq_laneq_s32(acc, weights, x, 1);
  if (lane == 2) return vdotq_laneq_s32(acc, weights, x, 2);
  return vdotq_laneq_s32(acc, weights, x, 3);
}

/// Four outputs a register, one instruction for four inputs of each.
template <int kPixelCount, int kUnitCount>
struct Tile {
  static constexpr int kPixels = kPixelCount;
  static constexpr int kUnits = kUnitCount;
  static constexpr int kStreams = 1;
  static constexpr bool kStartsEmpty = false;
  static constexpr bool kTakesRows = true;
  static constexpr bool kLoopEach = false;
  int32x4_t acc[kPixels][kUnits];

  EGOFOCUS_INLINE void start(const std::int32_t* bias) noexcept {
    const Quads<kUnits> q = load_quads<kUnits>(bias);
    EGOFOCUS_UNROLL
    for (int u = 0; u < kUnits; ++u) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) acc[p][u] = vreinterpretq_s32_s8(q.val[u]);
    }
  }

  template <int kLane>
  EGOFOCUS_INLINE void add_group(const int8x16_t* x, const std::int8_t*& weights) noexcept {
    const Quads<kUnits> w = load_quads<kUnits>(weights);
    go_on(weights, 64);
    EGOFOCUS_UNROLL
    for (int u = 0; u < kUnits; ++u) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) acc[p][u] = vdotq_laneq_s32(acc[p][u], w.val[u], x[p], kLane);
    }
  }

  EGOFOCUS_INLINE void add(const ConvBlock& block, const ConvRuns& runs) noexcept {
    const std::int64_t rest = runs.channels & 15;
    const std::int64_t whole = runs.channels - rest;
    const std::int8_t* weights = block.weights;
    const std::int8_t* input[kPixels];
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) input[p] = with_sign(block.input + p * block.pixel_step);
    for (std::int32_t run = 0; run != runs.count; ++run) {
      std::int64_t i = runs.offset[run];
      int8x16_t x[kPixels];
      for (const std::int64_t end = i + whole; i != end; i += 16) {
        EGOFOCUS_UNROLL
        for (int p = 0; p < kPixels; ++p) x[p] = vld1q_s8(input[p] + i);
        add_group<0>(x, weights);
        add_group<1>(x, weights);
        add_group<2>(x, weights);
        add_group<3>(x, weights);
      }
      if (rest >= 8) {
        EGOFOCUS_UNROLL
        for (int p = 0; p < kPixels; ++p) x[p] = vcombine_s8(vld1_s8(input[p] + i), vdup_n_s8(0));
        add_group<0>(x, weights);
        add_group<1>(x, weights);
        i += 8;
      }
      if (rest % 8 != 0) {
        EGOFOCUS_UNROLL
        for (int p = 0; p < kPixels; ++p) x[p] = vcombine_s8(four_bytes(input[p] + i), vdup_n_s8(0));
        add_group<0>(x, weights);
      }
    }
  }

  template <bool kFirst>
  EGOFOCUS_INLINE void add_row_of_eights(const std::int8_t* from, const std::int8_t** weights) noexcept {
    int8x16_t x[(kPixels + 3) / 2];
    EGOFOCUS_UNROLL
    for (int i = 0; i < (kPixels + 2) / 2; ++i) x[i] = vld1q_s8(from + 16 * i);
    if constexpr (kPixels % 2 != 0)
      x[(kPixels + 1) / 2] = vcombine_s8(vld1_s8(from + 8 * (kPixels + 1)), vdup_n_s8(0));
    EGOFOCUS_UNROLL
    for (int group = 0; group < 6; ++group) {
      int8x16_t w[kUnits];
      EGOFOCUS_UNROLL
      for (int u = 0; u < kUnits; ++u) w[u] = vld1q_s8(*weights + 64 * group + 16 * u);
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) {
        const int four = 2 * p + group;
        EGOFOCUS_UNROLL
        for (int u = 0; u < kUnits; ++u) acc[p][u] = dot_lane(acc[p][u], w[u], x[four / 4], four % 4);
      }
    }
    go_on(*weights, 384);
  }

  template <bool kAdd>
  EGOFOCUS_INLINE void leave(ByteLeaving& leaving, const float* scales) const noexcept {
    const Quads<kUnits> q = load_quads<kUnits>(scales);
    float32x4_t scale[kUnits];
    EGOFOCUS_UNROLL
    for (int u = 0; u < kUnits; ++u) scale[u] = vreinterpretq_f32_s8(q.val[u]);
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) leave_bytes<kUnits, kAdd>(leaving, narrow_units<kUnits>(acc[p], scale));
  }

  EGOFOCUS_INLINE void store(std::int32_t* sums) const noexcept {
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) {
      EGOFOCUS_UNROLL
      for (int u = 0; u < kUnits; ++u) vst1q_s32(sums + 4 * (p * kUnits + u), acc[p][u]);
    }
  }
};

// 32 registers: the sums, sixteen bytes of each pixel, a group's weights.
constexpr ConvBody kBody{kConvPacking_neondot,
                         4,
                         4,
                         {neon_widths<Tile, 10, 1>(), neon_widths<Tile, 9, 2>(), neon_widths<Tile, 7, 3>(),
                          neon_widths<Tile, 5, 4>()},
                         EGOFOCUS_LEAVE};

}  // namespace

void conv_u8s8_neondot(const ConvU8S8& conv) noexcept {
  if (!scored_alone(conv, kBody.packing.group_inputs)) conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
