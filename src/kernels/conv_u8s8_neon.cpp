#include "kernels/conv_u8s8_neon.inc"

namespace egofocus {
namespace {

/// Sixteen products are two multiplications into 16 bits (bytes up to 127: two products fit) and one pairwise
/// addition into 32.
#if defined(__aarch64__)
inline int16x8_t products_16(int8x16_t x, int8x16_t w) noexcept {
  // The upper half first: in the other order g++ copies w, whose lower half it takes for a value that ends.
  return vmlal_s8(vmull_high_s8(x, w), vget_low_s8(x), vget_low_s8(w));
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

/// Four outputs of two neighbouring pixels.
template <bool kAdd>
EGOFOCUS_INLINE void leave_two(ByteLeaving& leaving, int8x8_t bytes) noexcept {
  if constexpr (kAdd) {
    const int32x2_t x = vreinterpret_s32_s8(four_bytes(with_sign(leaving.addend)));
    const int32x2_t y = vreinterpret_s32_s8(four_bytes(with_sign(leaving.addend + leaving.addend_step)));
    bytes = vqadd_s8(bytes, vreinterpret_s8_s32(vset_lane_s32(vget_lane_s32(y, 0), x, 1)));
    leaving.addend += 2 * leaving.addend_step;
  }
  bytes = vmax_s8(bytes, vdup_n_s8(leaving.least));
  store_four(leaving.output, bytes);
  store_four(leaving.output + leaving.output_step, vext_s8(bytes, bytes, 4));
  leaving.output += 2 * leaving.output_step;
}

/// A register of partial sums for each pixel and output. Each unit of four outputs is a packed tile, a stream
/// of weights of its own.
template <int kPixelCount, int kUnitCount>
struct Tile {
  static constexpr int kPixels = kPixelCount;
  static constexpr int kUnits = kUnitCount;
  static constexpr int kStreams = kUnits;
  static constexpr int kAtOnce = kUnits == 1 ? 1 : 4;  // registers of weights
  static constexpr bool kStartsEmpty = true;
  static constexpr bool kTakesRows = kUnits == 1;
  static constexpr bool kLoopEach = false;
  int32x4_t acc[kPixels][4 * kUnits];
  const std::int32_t* bias;

  EGOFOCUS_INLINE void start(const std::int32_t* of_outputs) noexcept { bias = of_outputs; }

  EGOFOCUS_INLINE int32x4_t sum(int p, int u, const int32x4_t* with) const noexcept {
    return vaddq_s32(across(acc[p] + 4 * u), with[u]);
  }

  EGOFOCUS_INLINE void load_bias(int32x4_t* to) const noexcept {
    EGOFOCUS_UNROLL
    for (int u = 0; u < kUnits; ++u) to[u] = vld1q_s32(bias + 4 * u);
  }

  /// The first sixteen inputs of a block need no zeros to be added to.
  template <bool kFirst>
  EGOFOCUS_INLINE void add_16(const int8x16_t* x, const std::int8_t** weights) noexcept {
    EGOFOCUS_UNROLL
    for (int o = 0; o < 4 * kUnits; o += kAtOnce) {
      const Quads<kAtOnce> w = load_quads<kAtOnce>(weights[o / 4]);
      go_on(weights[o / 4], 16 * kAtOnce);
      EGOFOCUS_UNROLL
      for (int i = 0; i < kAtOnce; ++i) {
        EGOFOCUS_UNROLL
        for (int p = 0; p < kPixels; ++p) {
          const int16x8_t products = products_16(x[p], w.val[i]);
          acc[p][o + i] = kFirst ? vpaddlq_s16(products) : vpadalq_s16(acc[p][o + i], products);
        }
      }
    }
  }

  template <bool kFirst>
  EGOFOCUS_INLINE void add_next_16(const std::int8_t** input, const std::int8_t** weights) noexcept {
    int8x16_t x[kPixels];
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) {
      x[p] = vld1q_s8(input[p]);
      go_on(input[p], 16);
    }
    add_16<kFirst>(x, weights);
  }

  template <bool kFirst>
  EGOFOCUS_INLINE void add_next_32(const std::int8_t** input, const std::int8_t** weights) noexcept {
    int8x16_t x[2][kPixels];
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) {
      const Quads<2> both = load_quads<2>(input[p]);
      go_on(input[p], 32);
      x[0][p] = both.val[0];
      x[1][p] = both.val[1];
    }
    add_16<kFirst>(x[0], weights);
    add_16<false>(x[1], weights);
  }

  EGOFOCUS_INLINE void add_8(const int8x8_t* x, const std::int8_t* const* weights) noexcept {
    EGOFOCUS_UNROLL
    for (int o = 0; o < 4 * kUnits; ++o) {
      const int8x8_t w = vld1_s8(weights[o / 4] + 16 * (o % 4));
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) acc[p][o] = vpadalq_s16(acc[p][o], vmull_s8(x[p], w));
    }
  }

  EGOFOCUS_INLINE void go_on_all(const std::int8_t** streams, int count, std::int64_t bytes) const noexcept {
    EGOFOCUS_UNROLL
    for (int i = 0; i < count; ++i) go_on(streams[i], bytes);
  }

  /// Fewer than sixteen inputs: not all of a group of weights.
  EGOFOCUS_INLINE void add_rest(const std::int8_t** input, const std::int8_t** weights,
                                std::int64_t rest) noexcept {
    __asm__("" : "+r"(rest));  // or parts of it are made ready for every block
    int8x8_t x[kPixels];
    if ((rest & 8) != 0) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = vld1_s8(input[p]);
      add_8(x, weights);
      go_on_all(input, kPixels, 8);
      go_on_all(weights, kUnits, 8);
    }
    if ((rest & 4) != 0) {
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = four_bytes(input[p]);
      add_8(x, weights);
      go_on_all(input, kPixels, 4);
    }
    go_on_all(weights, kUnits, 64 - (rest & 8));
  }

  EGOFOCUS_INLINE void add(const ConvBlock& block, const ConvRuns& runs) noexcept {
    const std::int64_t rest = runs.channels & 15;
    const std::int64_t whole = runs.channels - rest;
    const std::int8_t* weights[kUnits];
    set_weights<kUnits>(block, weights);
    const std::int8_t* input[kPixels];
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p)
      input[p] = with_sign(block.input) + runs.offset[0] + p * block.pixel_step;
    std::int64_t left = whole;
    if (whole != 0) {
      add_next_16<true>(input, weights);
      left -= 16;
    } else {
      EGOFOCUS_UNROLL
      for (int o = 0; o < 4 * kUnits; ++o) {
        EGOFOCUS_UNROLL
        for (int p = 0; p < kPixels; ++p) acc[p][o] = vdupq_n_s32(0);
      }
    }
    const std::int64_t* const end = runs.offset + runs.count;
    for (const std::int64_t* run = runs.offset;;) {
      if (left != 0) {
        do {
          add_next_16<false>(input, weights);
          left -= 16;
        } while (left != 0);
      }
      if (rest != 0) add_rest(input, weights, rest);
      if (++run == end) return;
      go_on_all(input, kPixels, run[0] - run[-1] - whole - rest);
      left = whole;
    }
  }

  template <bool kFirst>
  EGOFOCUS_INLINE void add_row_of_eights(const std::int8_t* from, const std::int8_t** weights) noexcept {
    int8x8_t x[kPixels + 2];
    EGOFOCUS_UNROLL
    for (int i = 0; i < kPixels + 2; ++i) x[i] = vld1_s8(from + 8 * i);
    EGOFOCUS_UNROLL
    for (int o = 0; o < 4; ++o) {
      const int8x8_t w0 = vld1_s8(*weights + 16 * o);
      const int8x8_t w1 = vld1_s8(*weights + 16 * o + 64);
      const int8x8_t w2 = vld1_s8(*weights + 16 * o + 128);
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) {
        const int16x8_t two = vmlal_s8(vmull_s8(x[p], w0), x[p + 1], w1);
        acc[p][o] = kFirst ? vpaddlq_s16(two) : vpadalq_s16(acc[p][o], two);
        acc[p][o] = vpadalq_s16(acc[p][o], vmull_s8(x[p + 2], w2));
      }
    }
    go_on(*weights, 192);
  }

  template <bool kAdd>
  EGOFOCUS_INLINE void leave(ByteLeaving& leaving, const float* scales) const noexcept {
    int32x4_t with[kUnits];
    load_bias(with);
    float32x4_t scale[kUnits];
    EGOFOCUS_UNROLL
    for (int u = 0; u < kUnits; ++u) scale[u] = vld1q_f32(scales + 4 * u);
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; p += kUnits == 1 ? 2 : 1) {
      int32x4_t sums[kUnits];
      EGOFOCUS_UNROLL
      for (int u = 0; u < kUnits; ++u) sums[u] = sum(p, u, with);
      if (kUnits == 1 && p + 1 < kPixels) {
        const int16x8_t both = requant_s16_neon(sums[0], sum(p + 1, 0, with), scale[0], scale[0]);
        leave_two<kAdd>(leaving, vqmovn_s16(both));
      } else {
        leave_bytes<kUnits, kAdd>(leaving, narrow_units<kUnits>(sums, scale));
      }
    }
  }

  EGOFOCUS_INLINE void store(std::int32_t* sums) const noexcept {
    int32x4_t with[kUnits];
    load_bias(with);
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) {
      EGOFOCUS_UNROLL
      for (int u = 0; u < kUnits; ++u) vst1q_s32(sums + 4 * (p * kUnits + u), sum(p, u, with));
    }
  }
};

#if defined(__aarch64__)  // 32 registers
constexpr int kMostPixels = 5;
constexpr ConvBody kBody{kConvPacking_neon,
                         4,
                         2,
                         {neon_widths<Tile, kMostPixels, 1>(), neon_widths<Tile, 2, 2>()},
                         EGOFOCUS_LEAVE};
#else  // 16 registers
constexpr int kMostPixels = 2;
constexpr ConvBody kBody{kConvPacking_neon, 4, 1, {neon_widths<Tile, kMostPixels, 1>()}, EGOFOCUS_LEAVE};
#endif
// Eight inputs' neighbours share more of what is read the more pixels there are.
constexpr ConvBody kOfEights{kConvPacking_neon, 4, 1, {neon_widths<Tile, kMostPixels, 1>()}, EGOFOCUS_LEAVE};

// --- 3x3 with 4 or 8 inputs: several taps in a register ---

/// Taps in the order in which they fill registers. Neighbours that are read as one stand together.
constexpr int kGathered[9] = {0, 1, 3, 4, 6, 7, 2, 5, 8};

inline int8x16_t both(int8x8_t low, int8x8_t high) noexcept {
  return vcombine_s8(low, high);
}

inline int8x8_t two_fours(const std::int8_t* low, const std::int8_t* high) noexcept {
  return vreinterpret_s8_s32(
      vzip_s32(vreinterpret_s32_s8(four_bytes(low)), vreinterpret_s32_s8(four_bytes(high))).val[0]);
}

/// Dense pixels at stride 1. kAdjacent: dilation 1, so that a row's taps follow each other in memory.
template <int kChannels, bool kAdjacent, int kPixelCount, int kUnitCount>
struct GatheringTile : Tile<kPixelCount, kUnitCount> {
  using Tile<kPixelCount, kUnitCount>::acc;
  static constexpr int kPixels = kPixelCount;
  static constexpr bool kTakesRows = false;              // its weights lie otherwise
  static constexpr int kRegisters = 9 * kChannels / 16;  // full ones; the last tap is left over

  static EGOFOCUS_INLINE int8x16_t gathered(const std::int8_t* const* taps, int r, std::int64_t at) noexcept {
    if constexpr (kChannels == 8) {
      const std::int8_t* const first = taps[kGathered[2 * r]] + at;
      if (kAdjacent && r < 3) return vld1q_s8(first);
      return both(vld1_s8(first), vld1_s8(taps[kGathered[2 * r + 1]] + at));
    } else {
      if (r == 0) return both(vld1_s8(taps[0] + at), vld1_s8(taps[3] + at));
      return both(vld1_s8(taps[6] + at), two_fours(taps[2] + at, taps[5] + at));
    }
  }

  EGOFOCUS_INLINE void add(const ConvBlock& block, const ConvRuns& runs) noexcept {
    const std::int8_t* weights[kUnitCount];
    set_weights<kUnitCount>(block, weights);
    const std::int8_t* taps[9];
    EGOFOCUS_UNROLL
    for (int t = 0; t < 9; ++t) taps[t] = with_sign(block.input) + runs.offset[t];
    EGOFOCUS_UNROLL
    for (int r = 0; r < kRegisters; ++r) {
      int8x16_t x[kPixels];
      EGOFOCUS_UNROLL
      for (int p = 0; p < kPixels; ++p) x[p] = gathered(taps, r, p * kChannels);
      if (r == 0) {
        this->template add_16<true>(x, weights);
      } else {
        this->template add_16<false>(x, weights);
      }
    }
    int8x8_t x[kPixels];
    EGOFOCUS_UNROLL
    for (int p = 0; p < kPixels; ++p) {
      const std::int8_t* const last = taps[8] + p * kChannels;
      x[p] = kChannels == 8 ? vld1_s8(last) : four_bytes(last);
    }
    this->add_8(x, weights);
  }
};
template <int kPixels, int kUnits>
using FourAdjacent = GatheringTile<4, true, kPixels, kUnits>;
template <int kPixels, int kUnits>
using EightAdjacent = GatheringTile<8, true, kPixels, kUnits>;
template <int kPixels, int kUnits>
using EightApart = GatheringTile<8, false, kPixels, kUnits>;

template <template <int, int> typename GatheringTile>
constexpr ConvBody gathering_body() noexcept {
  return {kConvPacking_neon, 4, 1, {neon_widths<GatheringTile, kMostPixels, 1>()}, EGOFOCUS_LEAVE, true};
}
constexpr ConvBody kFourAdjacent = gathering_body<FourAdjacent>();
constexpr ConvBody kEightAdjacent = gathering_body<EightAdjacent>();
constexpr ConvBody kEightApart = gathering_body<EightApart>();

constexpr std::int32_t kMostGathered = 64;  // outputs

/// Whether it was such a layer; then it is done. Its weights, packed a tap a register, are gathered anew for
/// the call: as much work as a few pixels.
inline bool gathered_alone(const ConvU8S8& given) noexcept {
  constexpr std::int32_t kTile = 9 * 64;
  const std::int32_t channels = given.in_channels;
  const bool adjacent = given.dilation == 1;
  if (given.side != 3 || given.depth != 1 || given.stride != 1 || given.input_pixel_stride != channels ||
      !(channels == 8 || (channels == 4 && adjacent)) || given.out_channels > kMostGathered)
    return false;
  alignas(16) std::int8_t weights[kMostGathered / 4 * kTile];
  for (std::int32_t at = 0; at < (given.out_channels + 3) / 4 * kTile; at += kTile) {
    __builtin_memset(weights + at, 0, kTile);
    for (std::int32_t t = 0; t < 9; ++t) {
      const std::int8_t* const from = given.packed.weights + at + kGathered[t] * 64;
      std::int8_t* const to = weights + at + t * channels / 16 * 64 + t * channels % 16;
      for (std::int32_t o = 0; o < 4; ++o)
        __builtin_memcpy(to + 16 * o, from + 16 * o, static_cast<std::size_t>(channels));
    }
  }
  ConvU8S8 conv = given;
  conv.packed.weights = weights;
  conv.zeros_beyond = false;  // all nine taps, always
  conv_by_blocks(conv, channels == 4 ? kFourAdjacent : (adjacent ? kEightAdjacent : kEightApart));
  return true;
}

}  // namespace

void conv_u8s8_neon(const ConvU8S8& conv) noexcept {
  if (scored_alone(conv, kBody.packing.group_inputs) || gathered_alone(conv)) return;
  conv_by_blocks(conv, conv.in_channels == 8 ? kOfEights : kBody);
}

}  // namespace egofocus
