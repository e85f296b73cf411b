// What all vector bodies of conv_u8s8 share: an image is cut into blocks of a few pixels by a few tiles of
// outputs whose sums fit the registers. A body supplies the sums of a block, and how they leave. Each body
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

namespace egofocus {
namespace {

inline constexpr std::int32_t kMostBlockSums = 512;
inline constexpr std::int32_t kMostTileGroups = 5;

/// Runs of bytes that a pixel's sum reads one after the other: the taps, or whole rows of them where
/// neighbouring pixels' channels follow each other without a gap.
struct ConvRuns {
  std::int64_t offset[9];  // bytes from the output pixel's own input pixel
  std::int32_t count;
  std::int32_t channels;  // of one run
};

struct ConvBlock {
  const std::uint8_t* input;  // of the block's first pixel
  std::int64_t pixel_step;    // bytes between the inputs of neighbouring output pixels
  const std::int8_t* weights;
  std::int64_t tile_stride;  // bytes of one tile's weights
  const std::int32_t* bias;
  const ConvRuns* runs;
  std::int32_t* sums;  // [pixels][tiles][outputs of a tile]
};

/// Sums that are to leave: `pixels` of them, `outputs` valid channels in rows of `row` sums.
struct ConvLeaving {
  const std::int32_t* sums;
  std::int32_t pixels;
  std::int32_t row;
  std::int32_t outputs;
  const float* scale;
  ConvEpilogue epilogue;
  const std::uint8_t* addend;  // of the first pixel's first channel, as is output
  std::int64_t addend_step;
  std::uint8_t* output;
  std::int64_t output_step;
};

using ConvSumsFunction = void(const ConvBlock& block) noexcept;
using ConvLeaveFunction = void(const ConvLeaving& leaving) noexcept;

/// Blocks of one number of tiles. `pixels` is the widest; the others are for what it leaves over.
struct ConvBlockWidths {
  std::int32_t pixels;
  ConvSumsFunction* widest;
  ConvSumsFunction* one_less;
  ConvSumsFunction* half;
  ConvSumsFunction* single;
};

struct ConvBody {
  ConvPacking packing;
  std::int32_t most_tiles;                    // of a block, <= kMostTileGroups
  ConvBlockWidths by_tiles[kMostTileGroups];  // [tiles - 1]
  ConvLeaveFunction* leave;
};

/// Each tap a run, or, with whole_rows, each row of taps.
inline ConvRuns conv_taps(const ConvU8S8& conv, bool whole_rows = false) noexcept {
  const std::int64_t half = conv.side / 2 * conv.dilation;
  const std::int32_t across = whole_rows ? 1 : conv.side;
  ConvRuns runs{};
  runs.channels = whole_rows ? 3 * conv.in_channels : conv.in_channels;
  for (std::int32_t ky = 0; ky < conv.side; ++ky) {
    for (std::int32_t kx = 0; kx < across; ++kx) {
      const std::int64_t y = ky * conv.dilation - half;
      const std::int64_t x = kx * conv.dilation - half;
      runs.offset[runs.count++] = y * conv.input_row_stride + x * conv.input_pixel_stride;
    }
  }
  return runs;
}

inline ConvRuns conv_runs(const ConvU8S8& conv, std::int32_t group_inputs) noexcept {
  return conv_taps(conv, conv.side == 3 && conv.dilation == 1 &&
                             conv.input_pixel_stride == conv.in_channels &&
                             conv.in_channels % group_inputs == 0);
}

struct ConvTileGroup {
  std::int32_t first;  // tile
  std::int32_t tiles;
};

inline void conv_block(const ConvU8S8& conv, const ConvBody& body, const ConvTileGroup& group,
                       ConvSumsFunction* run, ConvBlock& block, std::int32_t row, std::int32_t column,
                       std::int32_t pixels) noexcept {
  const std::int32_t first_output = group.first * body.packing.tile_outputs;
  const std::int32_t left = conv.out_channels - first_output;
  const std::int32_t wide = group.tiles * body.packing.tile_outputs;
  block.input =
      conv.input + std::int64_t{row} * conv.stride * conv.input_row_stride + column * block.pixel_step;
  run(block);
  const std::int32_t element = conv.epilogue == ConvEpilogue::kScore ? 2 : 1;
  ConvLeaving leaving{};
  leaving.sums = block.sums;
  leaving.pixels = pixels;
  leaving.row = wide;
  leaving.outputs = left < wide ? left : wide;
  leaving.scale = conv.packed.scale + first_output;
  leaving.epilogue = conv.epilogue;
  if (conv.epilogue == ConvEpilogue::kAdd) {
    leaving.addend = conv.addend + std::int64_t{row} * conv.addend_row_stride +
                     std::int64_t{column} * conv.addend_pixel_stride + first_output;
    leaving.addend_step = conv.addend_pixel_stride;
  }
  leaving.output = static_cast<std::uint8_t*>(conv.output) + std::int64_t{row} * conv.output_row_stride +
                   std::int64_t{column} * conv.output_pixel_stride + first_output * element;
  leaving.output_step = conv.output_pixel_stride;
  body.leave(leaving);
}

inline void conv_row(const ConvU8S8& conv, const ConvBody& body, const ConvTileGroup& group, ConvBlock& block,
                     std::int32_t row) noexcept {
  const ConvBlockWidths& widths = body.by_tiles[group.tiles - 1];
  std::int32_t blocks = (conv.columns + widths.pixels - 1) / widths.pixels;
  // Blocks one pixel narrower than the widest lose next to nothing; a narrow rest would.
  const bool even = conv.columns >= blocks * (widths.pixels - 1);
  std::int32_t narrower = even ? blocks * widths.pixels - conv.columns : 0;
  std::int32_t column = 0;
  while (column < conv.columns) {
    const std::int32_t left = conv.columns - column;
    std::int32_t pixels = 1;
    ConvSumsFunction* run = widths.single;
    if (narrower > 0) {
      --narrower;
      pixels = widths.pixels - 1;
      run = widths.one_less;
    } else if (left >= widths.pixels) {
      pixels = widths.pixels;
      run = widths.widest;
    } else if (left >= widths.pixels / 2) {
      pixels = widths.pixels / 2;
      run = widths.half;
    }
    conv_block(conv, body, group, run, block, row, column, pixels);
    column += pixels;
  }
}

inline void conv_by_blocks(const ConvU8S8& conv, const ConvBody& body) noexcept {
  const std::int32_t tile_outputs = body.packing.tile_outputs;
  const std::int32_t group_inputs = body.packing.group_inputs;
  const std::int32_t tiles = (conv.out_channels + tile_outputs - 1) / tile_outputs;
  const std::int64_t groups = (conv.in_channels + group_inputs - 1) / group_inputs;
  const ConvRuns runs = conv_runs(conv, group_inputs);
  alignas(64) std::int32_t sums[kMostBlockSums];
  ConvTileGroup group{};
  while (group.first < tiles) {
    const std::int32_t left = tiles - group.first;
    // Two groups of about one size, where one of the widest would leave a narrow one.
    group.tiles = left <= body.most_tiles ? left : body.most_tiles;
    if (left > body.most_tiles && left < 2 * body.most_tiles) group.tiles = (left + 1) / 2;
    ConvBlock block{};
    block.pixel_step = std::int64_t{conv.stride} * conv.input_pixel_stride;
    block.tile_stride = conv.side * conv.side * groups * group_inputs * tile_outputs;
    block.weights = conv.packed.weights + group.first * block.tile_stride;
    block.bias = conv.packed.bias + group.first * tile_outputs;
    block.runs = &runs;
    block.sums = sums;
    for (std::int32_t row = conv.first_row; row < conv.first_row + conv.rows; ++row)
      conv_row(conv, body, group, block, row);
    group.first += group.tiles;
  }
}

}  // namespace
}  // namespace egofocus
