// What all vector bodies of conv_u8s8 share: an image is cut into blocks of a few pixels by a few
// outputs, whose sums fit the registers. A body supplies the sums of a block, and how they leave. Each body
// compiles its own copy with its flags: all of it is of internal linkage.
#pragma once

#include <cstdint>

#include "kernels/conv_u8s8.hpp"

// Loops over registers: what is left rolled lives in memory.
#if defined(__clang__)
#define EGOFOCUS_UNROLL _Pragma("unroll")
#else
#define EGOFOCUS_UNROLL _Pragma("GCC unroll 32")
#endif

/// The four instances of a body's leave_as.
#define EGOFOCUS_LEAVE                                                                           \
  {                                                                                              \
    leave_as<ConvEpilogue::kRelu>, leave_as<ConvEpilogue::kAdd>, leave_as<ConvEpilogue::kSmall>, \
        leave_as<ConvEpilogue::kScore>                                                           \
  }

namespace egofocus {
namespace {

inline constexpr std::int32_t kMostBlockSums = 512;
inline constexpr std::int32_t kMostUnits = 5;

/// Runs of bytes that a pixel's sum reads one after the other: the taps, or whole rows of them where
/// neighbouring pixels' channels follow each other without a gap.
struct ConvRuns {
  std::int64_t offset[27];  // bytes from the output pixel's own input pixel
  std::int32_t count;
  std::int32_t channels;  // of one run
  bool eights;            // whole rows, each pixel's eight bytes after its neighbour's
};

struct ConvBlock {
  const std::uint8_t* input;  // of the block's first pixel
  std::int64_t pixel_step;    // bytes between the inputs of neighbouring output pixels
  const std::int8_t* weights;
  std::int64_t tile_stride;  // bytes of one tile's weights
  const std::int32_t* bias;
  const ConvRuns* runs;
  std::int32_t* sums;  // [pixels][units][outputs of a unit]
};

/// Sums that are to leave: `pixels` of them, `outputs` valid channels in rows of `row` sums.
struct ConvLeaving {
  const std::int32_t* sums;
  std::int32_t pixels;
  std::int32_t row;
  std::int32_t outputs;
  const float* scale;
  const std::uint8_t* addend;  // of the first pixel's first channel, as is output; null without one
  std::int64_t addend_step;
  std::uint8_t* output;
  std::int64_t output_step;
};

using ConvSumsFunction = void(const ConvBlock& block) noexcept;
using ConvLeaveFunction = void(const ConvLeaving& leaving) noexcept;

struct ConvPlan;
/// Neighbouring blocks of a row, one after the other; moves the plan's pointers on.
using ConvBlocksFunction = void(ConvPlan& plan, std::int32_t blocks) noexcept;

/// Blocks of one number of units. `pixels` is the widest; the others are for what it leaves over.
struct ConvBlockWidths {
  std::int32_t pixels;
  std::int32_t fewer;  // pixels of `narrower`
  ConvBlocksFunction* widest;
  ConvBlocksFunction* narrower;
  ConvBlocksFunction* half;
  ConvBlocksFunction* single;
  bool in_pairs = false;  // an odd number of pixels costs as much as the even one above it
};

/// A unit is what a block's outputs are counted in: a packed tile, or, where a tile is all that a block can
/// hold, the part of it that may be left out at the end of a layer.
struct ConvBody {
  ConvPacking packing;
  std::int32_t unit_outputs;
  std::int32_t most_units;               // of a block, <= kMostUnits; one tile, if units are parts of it
  ConvBlockWidths by_units[kMostUnits];  // [units - 1]
  ConvLeaveFunction* leave[4];           // by ConvEpilogue
  bool taps_apart = false;               // its tiles want each tap a run, even where rows lie together
};

/// Each tap a run, or, with whole_rows, each row of taps.
inline ConvRuns conv_taps(const ConvU8S8& conv, bool whole_rows = false) noexcept {
  const std::int64_t half = conv.side / 2 * conv.dilation;
  const std::int32_t across = whole_rows ? 1 : conv.side;
  ConvRuns runs{};
  runs.channels = whole_rows ? 3 * conv.in_channels : conv.in_channels;
  for (std::int32_t kz = 0; kz < conv.depth; ++kz) {
    const std::int64_t plane = (kz - conv.depth / 2) * conv.input_plane_stride;
    for (std::int32_t ky = 0; ky < conv.side; ++ky) {
      for (std::int32_t kx = 0; kx < across; ++kx) {
        const std::int64_t y = ky * conv.dilation - half;
        const std::int64_t x = kx * conv.dilation - half;
        runs.offset[runs.count++] = plane + y * conv.input_row_stride + x * conv.input_pixel_stride;
      }
    }
  }
  return runs;
}

inline ConvRuns conv_runs(const ConvU8S8& conv, std::int32_t group_inputs) noexcept {
  const bool dense = conv.side == 3 && conv.dilation == 1 && conv.input_pixel_stride == conv.in_channels;
  const bool eights = dense && conv.stride == 1 && conv.in_channels == 8;
  ConvRuns runs = conv_taps(conv, eights || (dense && conv.in_channels % group_inputs == 0));
  runs.eights = eights;
  return runs;
}

/// The runs of an output row, and their weights. Where nothing but zeros lies above and below the input,
/// those of its first and last rows are fewer; `all` stays the caller's.
struct ConvRowRuns {
  const ConvRuns* runs;
  const std::int8_t* weights;
  ConvRuns some;

  void set(const ConvU8S8& conv, const ConvRuns& all, const std::int8_t* first_weights,
           std::int64_t weights_per_ky, std::int32_t row) noexcept {
    runs = &all;
    weights = first_weights;
    const std::int32_t first = row * conv.stride - conv.side / 2 * conv.dilation;
    const std::int32_t last = first + (conv.side - 1) * conv.dilation;
    if (!conv.zeros_beyond || conv.depth != 1 || (first >= 0 && last < conv.input_rows)) return;
    const std::int32_t across = all.count / conv.side;
    some.count = 0;
    some.channels = all.channels;
    some.eights = all.eights;
    for (std::int32_t ky = 0; ky < conv.side; ++ky) {
      const std::int32_t y = first + ky * conv.dilation;
      if (y < 0) weights += weights_per_ky;
      if (y < 0 || y >= conv.input_rows) continue;
      for (std::int32_t i = 0; i < across; ++i) some.offset[some.count++] = all.offset[ky * across + i];
    }
    runs = &some;
  }
};

/// A call's rows for the outputs of one width of block.
struct ConvPlan {
  const ConvBlockWidths* widths;
  ConvEpilogue epilogue;
  ConvLeaveFunction* leave;
  ConvBlock block;
  ConvLeaving leaving;
};

inline void conv_move_on(ConvPlan& plan, std::int32_t pixels) noexcept {
  plan.block.input += pixels * plan.block.pixel_step;
  plan.leaving.output += pixels * plan.leaving.output_step;
  if (plan.leaving.addend != nullptr) plan.leaving.addend += pixels * plan.leaving.addend_step;
}

/// The blocks of a body whose sums go through memory.
template <ConvSumsFunction* kSums, std::int32_t kPixels>
void by_memory(ConvPlan& plan, std::int32_t blocks) noexcept {
  plan.leaving.pixels = kPixels;
  for (; blocks > 0; --blocks) {
    kSums(plan.block);
    plan.leave(plan.leaving);
    conv_move_on(plan, kPixels);
  }
}

inline void conv_row(ConvPlan& plan, std::int32_t columns) noexcept {
  const ConvBlockWidths& widths = *plan.widths;
  const std::int32_t blocks = (columns + widths.pixels - 1) / widths.pixels;
  // Blocks a little narrower than the widest lose next to nothing; a narrow rest would.
  const std::int32_t missing = blocks * widths.pixels - columns;
  const std::int32_t less = widths.pixels - widths.fewer;
  const bool halved = widths.in_pairs && 2 * missing == widths.pixels;
  const std::int32_t narrower =
      !halved && missing % less == 0 && missing / less <= blocks ? missing / less : 0;
  std::int32_t left = columns - narrower * widths.fewer;
  if (narrower > 0) widths.narrower(plan, narrower);
  if (left >= widths.pixels) widths.widest(plan, left / widths.pixels);
  left %= widths.pixels;
  const std::int32_t half = widths.pixels / 2;
  if (left >= half) widths.half(plan, left / half);
  if (left % half != 0) widths.single(plan, left % half);
}

/// All of a call's rows as a single one, where they follow each other without a gap and nothing looks beside
/// it.
inline ConvU8S8 conv_as_one_row(const ConvU8S8& conv) noexcept {
  const auto follow = [&](std::int32_t row, std::int32_t pixel) { return row == conv.columns * pixel; };
  const bool add = conv.epilogue == ConvEpilogue::kAdd;
  if (conv.side != 1 || conv.stride != 1 || !follow(conv.input_row_stride, conv.input_pixel_stride) ||
      !follow(conv.output_row_stride, conv.output_pixel_stride) ||
      (add && !follow(conv.addend_row_stride, conv.addend_pixel_stride)))
    return conv;
  ConvU8S8 row = conv;
  row.input += std::int64_t{conv.first_row} * conv.input_row_stride;
  if (add) row.addend += std::int64_t{conv.first_row} * conv.addend_row_stride;
  row.output =
      static_cast<std::uint8_t*>(conv.output) + std::int64_t{conv.first_row} * conv.output_row_stride;
  row.columns = conv.columns * conv.rows;
  row.first_row = 0;
  row.rows = 1;
  return row;
}

inline void conv_rows(const ConvU8S8& conv, ConvPlan& plan, std::int32_t first_output) noexcept {
  const ConvRuns* const runs = plan.block.runs;
  const std::int8_t* const weights = plan.block.weights;
  ConvRowRuns here;
  const std::int32_t element = conv.epilogue == ConvEpilogue::kScore ? 2 : 1;
  for (std::int32_t row = conv.first_row; row < conv.first_row + conv.rows; ++row) {
    here.set(conv, *runs, weights, plan.block.tile_stride / conv.side, row);
    plan.block.runs = here.runs;
    plan.block.weights = here.weights;
    plan.block.input = conv.input + std::int64_t{row} * conv.stride * conv.input_row_stride;
    if (conv.epilogue == ConvEpilogue::kAdd)
      plan.leaving.addend = conv.addend + std::int64_t{row} * conv.addend_row_stride + first_output;
    plan.leaving.output = static_cast<std::uint8_t*>(conv.output) +
                          std::int64_t{row} * conv.output_row_stride + first_output * element;
    conv_row(plan, conv.columns);
  }
  plan.block.runs = runs;
}

inline void conv_by_blocks(const ConvU8S8& given, const ConvBody& body) noexcept {
  const ConvU8S8 conv = conv_as_one_row(given);
  const std::int32_t tile = body.packing.tile_outputs;
  const std::int32_t inputs = body.packing.group_inputs;
  const std::int64_t groups = (conv.in_channels + inputs - 1) / inputs;
  const ConvRuns runs = body.taps_apart ? conv_taps(conv) : conv_runs(conv, inputs);
  alignas(64) std::int32_t sums[kMostBlockSums];
  ConvPlan plan{};
  plan.epilogue = conv.epilogue;
  plan.leave = body.leave[static_cast<int>(conv.epilogue)];
  plan.block.pixel_step = std::int64_t{conv.stride} * conv.input_pixel_stride;
  plan.block.tile_stride = conv.depth * conv.side * conv.side * groups * inputs * tile;
  plan.block.runs = &runs;
  plan.block.sums = sums;
  plan.leaving.sums = sums;
  plan.leaving.addend_step = conv.addend_pixel_stride;
  plan.leaving.output_step = conv.output_pixel_stride;
  std::int32_t first = 0;  // output
  while (first < conv.out_channels) {
    const std::int32_t left = (conv.out_channels - first + body.unit_outputs - 1) / body.unit_outputs;
    std::int32_t units = left <= body.most_units ? left : body.most_units;
    // Two blocks of about one size, where one of the widest would leave a narrow one.
    const bool halved = body.unit_outputs == tile && left > body.most_units && left < 2 * body.most_units;
    if (halved) units = (left + 1) / 2;
    const std::int32_t wide = units * body.unit_outputs;
    plan.widths = &body.by_units[units - 1];
    plan.block.weights = conv.packed.weights + first / tile * plan.block.tile_stride;
    plan.block.bias = conv.packed.bias + first;
    plan.leaving.row = wide;
    plan.leaving.outputs = conv.out_channels - first < wide ? conv.out_channels - first : wide;
    plan.leaving.scale = conv.packed.scale + first;
    conv_rows(conv, plan, first);
    first += wide;
  }
}

}  // namespace
}  // namespace egofocus
