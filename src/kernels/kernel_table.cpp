#include "kernels/kernel_table.hpp"

#ifdef EGOFOCUS_CHECK_KERNELS
#include "kernels/checked_kernels.hpp"
#define EGOFOCUS_RUN_WARP_VOTE(suffix, isa) &checked_warp_vote<&warp_vote_u8_##suffix, Isa::isa>
#define EGOFOCUS_RUN_CONV_U8S8(suffix, isa) \
  &checked_conv_u8s8<&conv_u8s8_##suffix, Isa::isa, kConvPacking_##suffix>
#define EGOFOCUS_RUN_DEPTHWISE_U8S8(suffix, isa) \
  &checked_depthwise_u8s8<&depthwise_u8s8_##suffix, Isa::isa, kDepthwisePacking_##suffix>
#else
#define EGOFOCUS_RUN_WARP_VOTE(suffix, isa) &warp_vote_u8_##suffix
#define EGOFOCUS_RUN_CONV_U8S8(suffix, isa) &conv_u8s8_##suffix
#define EGOFOCUS_RUN_DEPTHWISE_U8S8(suffix, isa) &depthwise_u8s8_##suffix
#endif

namespace egofocus {
namespace {

ChosenKernel<WarpVoteFunction> select_warp_vote(IsaSet allowed) noexcept {
#define EGOFOCUS_WARP_VOTE(suffix, isa) \
  if (has_isa(allowed, Isa::isa)) return {EGOFOCUS_RUN_WARP_VOTE(suffix, isa), Isa::isa};
#include "kernels/warp_vote.inc"
#undef EGOFOCUS_WARP_VOTE
  return {};
}

ChosenConvU8S8 select_conv_u8s8(IsaSet allowed) noexcept {
#define EGOFOCUS_CONV_U8S8(suffix, isa, tile_outputs, group_inputs) \
  if (has_isa(allowed, Isa::isa))                                   \
    return {{EGOFOCUS_RUN_CONV_U8S8(suffix, isa), Isa::isa}, kConvPacking_##suffix};
#include "kernels/conv_u8s8.inc"
#undef EGOFOCUS_CONV_U8S8
  return {};
}

ChosenDepthwiseU8S8 select_depthwise_u8s8(IsaSet allowed) noexcept {
#define EGOFOCUS_DEPTHWISE_U8S8(suffix, isa, block_channels, by_columns) \
  if (has_isa(allowed, Isa::isa))                                        \
    return {{EGOFOCUS_RUN_DEPTHWISE_U8S8(suffix, isa), Isa::isa}, kDepthwisePacking_##suffix};
#include "kernels/depthwise_u8s8.inc"
#undef EGOFOCUS_DEPTHWISE_U8S8
  return {};
}

}  // namespace

KernelTable select_kernels(IsaSet allowed) noexcept {
  const IsaSet with_scalar = allowed | isa_bit(Isa::kScalar);
  KernelTable table;
  table.warp_vote = select_warp_vote(with_scalar);
  table.conv_u8s8 = select_conv_u8s8(with_scalar);
  table.depthwise_u8s8 = select_depthwise_u8s8(with_scalar);
  return table;
}

void name_kernels(const KernelTable& table, bool with_network, std::span<char> out) noexcept {
  const char* const words[] = {"warp_vote ", isa_name(table.warp_vote.isa), ", conv_u8s8 ",
                               isa_name(table.conv_u8s8.isa)};
  std::size_t size = 0;
  for (const char* word : std::span(words).first(with_network ? 4 : 2)) {
    for (; *word != '\0' && size + 1 < out.size(); ++word) out[size++] = *word;
  }
  if (!out.empty()) out[size] = '\0';
}

}  // namespace egofocus
