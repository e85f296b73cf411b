#include "kernels/checked_kernels.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace egofocus {
namespace {

// The layer's weights in the scalar variant's order, from the packing that `conv` came with.
std::vector<std::int8_t> scalar_weights(const ConvPacking& packing, const ConvU8S8& conv) {
  const std::int64_t taps = std::int64_t{conv.depth} * conv.side * conv.side;
  const std::int64_t group = packing.group_inputs;
  const std::int64_t groups = (conv.in_channels + group - 1) / group;
  const std::int64_t tile = packing.tile_outputs;
  std::vector<std::int8_t> weights;
  for (std::int64_t o = 0; o < conv.out_channels; ++o) {
    for (std::int64_t tap = 0; tap < taps; ++tap) {
      for (std::int64_t i = 0; i < conv.in_channels; ++i) {
        const std::int64_t block = (o / tile * taps + tap) * groups + i / group;
        weights.push_back(conv.packed.weights[block * tile * group + o % tile * group + i % group]);
      }
    }
  }
  return weights;
}

}  // namespace

std::int64_t check_warp_vote(WarpVoteFunction* run, Isa isa, const WarpVote& vote) noexcept {
  const auto fail = [&](const char* what, std::int64_t at, std::int64_t got, std::int64_t meant) {
    std::fprintf(
        stderr,
        "egofocus: warp_vote %s differs from scalar: %s, hypothesis %lld, row %lld, column %lld: %lld "
        "in place of %lld (%d events on %dx%d px)\n",
        isa_name(isa), what, static_cast<long long>(vote.k_begin + at / vote.plane_stride),
        static_cast<long long>(at % vote.plane_stride / vote.row_stride),
        static_cast<long long>(at % vote.plane_stride % vote.row_stride), static_cast<long long>(got),
        static_cast<long long>(meant), vote.n, vote.width, vote.height);
    std::abort();
  };
  const std::int64_t bytes = vote.k_count * vote.plane_stride;
  std::vector<std::uint8_t> meant(vote.stack, vote.stack + bytes);
  WarpVote scalar = vote;
  scalar.stack = meant.data();
  const std::int64_t meant_votes = warp_vote_u8_scalar(scalar);
  const std::int64_t votes = run(vote);
  for (std::int64_t at = 0; at < bytes; ++at) {
    const std::uint8_t right = meant[static_cast<std::size_t>(at)];
    if (vote.stack[at] != right) fail("counts", at, vote.stack[at], right);
  }
  if (votes != meant_votes) fail("the number of votes", 0, votes, meant_votes);
  for (std::int64_t at = 0; vote.scratch != nullptr && at < std::int64_t{vote.width} * vote.height; ++at) {
    if (vote.scratch[at] != 0) fail("scratch left behind", at, vote.scratch[at], 0);
  }
  return votes;
}

void check_conv_u8s8(ConvU8S8Function* run, Isa isa, const ConvPacking& packing,
                     const ConvU8S8& conv) noexcept {
  const std::int32_t element = conv.epilogue == ConvEpilogue::kScore ? 2 : 1;
  const std::vector<std::int8_t> weights = scalar_weights(packing, conv);
  ConvU8S8 scalar = conv;
  scalar.packed.weights = weights.data();
  scalar.output_pixel_stride = conv.out_channels * element;
  scalar.output_row_stride = conv.columns * scalar.output_pixel_stride;
  // First, since the output may be the addend itself.
  std::vector<std::uint8_t> meant(static_cast<std::size_t>(conv.first_row + conv.rows) *
                                  static_cast<std::size_t>(scalar.output_row_stride));
  scalar.output = meant.data();
  conv_u8s8_scalar(scalar);
  run(conv);
  for (std::int32_t row = conv.first_row; row < conv.first_row + conv.rows; ++row) {
    for (std::int32_t column = 0; column < conv.columns; ++column) {
      const std::uint8_t* const got = static_cast<const std::uint8_t*>(conv.output) +
                                      std::int64_t{row} * conv.output_row_stride +
                                      std::int64_t{column} * conv.output_pixel_stride;
      const std::uint8_t* const right =
          &meant[static_cast<std::size_t>(row) * static_cast<std::size_t>(scalar.output_row_stride) +
                 static_cast<std::size_t>(column) * static_cast<std::size_t>(scalar.output_pixel_stride)];
      for (std::int32_t at = 0; at < conv.out_channels * element; ++at) {
        if (got[at] == right[at]) continue;
        std::fprintf(
            stderr,
            "egofocus: conv_u8s8 %s differs from scalar: row %d, column %d, output %d: byte %d in place "
            "of %d (%dx%dx%d, %d -> %d, stride %d, dilation %d, epilogue %d)\n",
            isa_name(isa), row, column, at / element, got[at], right[at], conv.depth, conv.side, conv.side,
            conv.in_channels, conv.out_channels, conv.stride, conv.dilation, static_cast<int>(conv.epilogue));
        std::abort();
      }
    }
  }
}

void check_depthwise_u8s8(DepthwiseU8S8Function* run, Isa isa, const DepthwisePacking& packing,
                          const DepthwiseU8S8& conv) noexcept {
  // The layer as it was given, from the first block that has the channel.
  std::vector<std::int8_t> weights;
  std::vector<std::int32_t> bias;
  std::vector<float> scale;
  for (std::int32_t c = 0; c < conv.channels; ++c) {
    const DepthwisePlace at = depthwise_place(packing, c);
    for (std::int32_t tap = 0; tap < 9; ++tap) weights.push_back(conv.packed.weights[at.of_tap[tap]]);
    bias.push_back(conv.packed.bias[at.of_channel]);
    scale.push_back(conv.packed.scale[at.of_channel]);
  }
  DepthwiseU8S8 scalar = conv;
  scalar.packed = {weights.data(), bias.data(), scale.data()};
  scalar.output_pixel_stride = conv.channels;
  scalar.output_row_stride = conv.columns * conv.channels;
  // First, since the output may be the addend itself.
  std::vector<std::uint8_t> meant(static_cast<std::size_t>(conv.first_row + conv.rows) *
                                  static_cast<std::size_t>(scalar.output_row_stride));
  scalar.output = meant.data();
  depthwise_u8s8_scalar(scalar);
  run(conv);
  for (std::int64_t i = std::int64_t{conv.first_row} * scalar.output_row_stride;
       i < static_cast<std::int64_t>(meant.size()); ++i) {
    const std::int64_t row = i / scalar.output_row_stride;
    const std::int64_t column = i % scalar.output_row_stride / conv.channels;
    const std::int64_t c = i % conv.channels;
    const std::uint8_t got =
        conv.output[row * conv.output_row_stride + column * conv.output_pixel_stride + c];
    const std::uint8_t right = meant[static_cast<std::size_t>(i)];
    if (got == right) continue;
    std::fprintf(stderr,
                 "egofocus: depthwise_u8s8 %s differs from scalar: row %lld, column %lld, channel %lld: byte "
                 "%d in place "
                 "of %d (%d channels, stride %d, dilation %d, epilogue %d)\n",
                 isa_name(isa), static_cast<long long>(row), static_cast<long long>(column),
                 static_cast<long long>(c), got, right, conv.channels, conv.stride, conv.dilation,
                 static_cast<int>(conv.epilogue));
    std::abort();
  }
}

}  // namespace egofocus
