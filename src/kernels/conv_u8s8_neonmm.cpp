#include "kernels/conv_u8s8_neon.inc"

namespace egofocus {
namespace {

inline int8x16_t join_low(int8x16_t a, int8x16_t b) noexcept {
  return vreinterpretq_s8_s64(vzip1q_s64(vreinterpretq_s64_s8(a), vreinterpretq_s64_s8(b)));
}

inline int8x16_t join_high(int8x16_t a, int8x16_t b) noexcept {
  return vreinterpretq_s8_s64(vzip2q_s64(vreinterpretq_s64_s8(a), vreinterpretq_s64_s8(b)));
}

/// Each pair of neighbouring words, twice.
template <int kCount>
EGOFOCUS_INLINE void twice(const void* words, Quads<kCount>& both) noexcept {
  const Quads<kCount / 2> q = load_quads<kCount / 2>(words);
  EGOFOCUS_UNROLL
  for (int o = 0; o < kCount; o += 2) {
    both.val[o] = join_low(q.val[o / 2], q.val[o / 2]);
    both.val[o + 1] = join_high(q.val[o / 2], q.val[o / 2]);
  }
}

/// Two pixels by two outputs a register, one instruction for eight inputs. Of an odd number of pixels the
/// last stands in for its neighbour.
template <int kPixelCount, int kUnitCount>
struct Tile {
  static constexpr int kPixels = kPixelCount;
  static constexpr int kUnits = kUnitCount;
  static constexpr int kStreams = 1;
  static constexpr bool kStartsEmpty = false;
  static constexpr bool kTakesRows = true;
  static constexpr bool kLoopEach = true;
  static constexpr int kPairs = (kPixels + 1) / 2;
  static constexpr int kColumns = kUnits == 3 ? 8 : 2 * kUnits;
  static constexpr int kAtOnce = kUnits == 1 ? 2 : 4;
  int32x4_t acc[kPairs][kColumns];

  EGOFOCUS_INLINE void start(const std::int32_t* bias) noexcept {
    Quads<kColumns> both;
    twice<kColumns>(bias, both);
    EGOFOCUS_UNROLL
    for (int o = 0; o < kColumns; ++o) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p) acc[p][o] = vreinterpretq_s32_s8(both.val[o]);
    }
  }

  template <int kFirst>
  EGOFOCUS_INLINE void add_columns(const int8x16_t* pairs, const std::int8_t*& weights) noexcept {
    const Quads<kAtOnce> w = load_quads<kAtOnce>(weights);
    go_on(weights, 64);
    EGOFOCUS_UNROLL
    for (int o = 0; o < kAtOnce; ++o) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p)
        acc[p][kFirst + o] = vmmlaq_s32(acc[p][kFirst + o], pairs[p], w.val[o]);
    }
  }

  EGOFOCUS_INLINE void add_group(const int8x16_t* pairs, const std::int8_t*& weights) noexcept {
    add_columns<0>(pairs, weights);
    if constexpr (kColumns > 4) {
      add_columns<4>(pairs, weights);
    } else {
      go_on(weights, 64);
    }
  }

  /// The inputs of two pixels go through pairs of registers: the first eight of each, then the next ones.
  EGOFOCUS_INLINE void load_pairs(const std::int8_t** input, int8x16_t (*pairs)[kPairs]) noexcept {
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPairs; ++p) {
      const int8x16_t a = vld1q_s8(input[2 * p]);
      const int8x16_t b = vld1q_s8(input[2 * p + 1]);
      go_on(input[2 * p], 16);
      go_on(input[2 * p + 1], 16);
      pairs[0][p] = join_low(a, b);
      pairs[1][p] = join_high(a, b);
    }
  }

  EGOFOCUS_INLINE void load_pairs_of_32(const std::int8_t** input, int8x16_t (*pairs)[kPairs]) noexcept {
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPairs; ++p) {
      const Quads<2> a = load_quads<2>(input[2 * p]);
      const Quads<2> b = load_quads<2>(input[2 * p + 1]);
      go_on(input[2 * p], 32);
      go_on(input[2 * p + 1], 32);
      EGOFOCUS_UNROLL
      for (int i = 0; i < 2; ++i) {
        pairs[2 * i][p] = join_low(a.val[i], b.val[i]);
        pairs[2 * i + 1][p] = join_high(a.val[i], b.val[i]);
      }
    }
  }

  EGOFOCUS_INLINE void add_run(const std::int8_t** input, const std::int8_t*& weights,
                               std::int32_t left) noexcept {
    int8x16_t pairs[4][kPairs];
    if constexpr (kPairs <= 2) {
      for (; left >= 32; left -= 32) {
        load_pairs_of_32(input, pairs);
        add_group(pairs[0], weights);
        add_group(pairs[1], weights);
        add_group(pairs[2], weights);
        add_group(pairs[3], weights);
      }
      if (left == 0) return;
    }
    for (; left >= 16; left -= 16) {
      load_pairs(input, pairs);
      add_group(pairs[0], weights);
      add_group(pairs[1], weights);
    }
    if (left >= 8) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p) {
        pairs[0][p] = vcombine_s8(vld1_s8(input[2 * p]), vld1_s8(input[2 * p + 1]));
        go_on(input[2 * p], 8);
        go_on(input[2 * p + 1], 8);
      }
      add_group(pairs[0], weights);
      left -= 8;
    }
    if (left != 0) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPairs; ++p) {
        pairs[0][p] = vcombine_s8(four_bytes(input[2 * p]), four_bytes(input[2 * p + 1]));
        go_on(input[2 * p], 4);
        go_on(input[2 * p + 1], 4);
      }
      add_group(pairs[0], weights);
    }
  }

  EGOFOCUS_INLINE void add(const ConvBlock& block, const ConvRuns& runs) noexcept {
    const std::int8_t* weights = block.weights;
    const std::int8_t* input[2 * kPairs];
    EGOFOCUS_UNROLL
    for (int p = 0; p < 2 * kPairs; ++p) {
      const int pixel = p < kPixels ? p : kPixels - 1;
      input[p] = with_sign(block.input) + runs.offset[0] + pixel * block.pixel_step;
    }
    for (std::int32_t run = 0;;) {
      add_run(input, weights, runs.channels);
      if (++run == runs.count) return;
      const std::int64_t gap = runs.offset[run] - runs.offset[run - 1] - runs.channels;
      EGOFOCUS_UNROLL
      for (int p = 0; p < 2 * kPairs; ++p) go_on(input[p], gap);
    }
  }

  /// Two neighbours' bytes lie side by side.
  template <bool kFirst>
  EGOFOCUS_INLINE void add_row_of_eights(const std::int8_t* from, const std::int8_t** weights) noexcept {
    int8x16_t even[kPairs + 1];
    int8x16_t odd[kPairs];
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPairs; ++p) {
      even[p] = vld1q_s8(from + 16 * p);
      odd[p] = vld1q_s8(from + 16 * p + 8);
    }
    const std::int8_t* last = from + 16 * kPairs;
    even[kPairs] = kPixels % 2 != 0 ? vcombine_s8(vld1_s8(last), vdup_n_s8(0)) : vld1q_s8(last);
    add_group(even, *weights);
    add_group(odd, *weights);
    add_group(even + 1, *weights);
  }

  template <bool kAdd>
  EGOFOCUS_INLINE void leave(ByteLeaving& leaving, const float* scales) const noexcept {
    constexpr int kHalves = kColumns / kAtOnce;
    int8x16_t bytes[kPairs][kHalves];  // two outputs of a pixel, two of the next one
    Quads<kColumns> both;
    twice<kColumns>(scales, both);
    float32x4_t scale[kColumns];
    EGOFOCUS_UNROLL
    for (int o = 0; o < kColumns; ++o) scale[o] = vreinterpretq_f32_s8(both.val[o]);
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPairs; ++p) {
      EGOFOCUS_UNROLL
      for (int half = 0; half < kHalves; ++half)
        bytes[p][half] = narrow_units<kAtOnce>(acc[p] + kAtOnce * half, scale + kAtOnce * half);
    }
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPairs; ++p) {
      const int16x8_t low = vreinterpretq_s16_s8(bytes[p][0]);
      const int16x8_t high = vreinterpretq_s16_s8(bytes[p][kHalves - 1]);
      leave_bytes<kUnits, kAdd>(leaving, vreinterpretq_s8_s16(vuzp1q_s16(low, high)));
      if (2 * p + 1 < kPixels)
        leave_bytes<kUnits, kAdd>(leaving, vreinterpretq_s8_s16(vuzp2q_s16(low, high)));
    }
  }

  EGOFOCUS_INLINE void store(std::int32_t* sums) const noexcept {
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) {
      EGOFOCUS_UNROLL
      for (int o = 0; o < 2 * kUnits; ++o) {
        const int32x4_t both = acc[p / 2][o];
        vst1_s32(sums + 4 * kUnits * p + 2 * o, p % 2 != 0 ? vget_high_s32(both) : vget_low_s32(both));
      }
    }
  }
};

// 32 registers: the sums, thirty-two inputs of each pixel, four times two outputs' weights.
constexpr ConvBody kBody{kConvPacking_neonmm,
                         4,
                         4,
                         {neon_widths<Tile, 8, 1, true>(), neon_widths<Tile, 8, 2, true>(),
                          neon_widths<Tile, 4, 3, true>(), neon_widths<Tile, 4, 4, true>()},
                         EGOFOCUS_LEAVE};

}  // namespace

void conv_u8s8_neonmm(const ConvU8S8& conv) noexcept {
  if (!scored_alone(conv, kBody.packing.group_inputs)) conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
