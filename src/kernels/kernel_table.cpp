#include "kernels/kernel_table.hpp"

namespace egofocus {
namespace {

ChosenKernel<WarpVoteFunction> select_warp_vote(IsaSet allowed) noexcept {
#define EGOFOCUS_WARP_VOTE(suffix, isa) \
  if (has_isa(allowed, Isa::isa)) return {&warp_vote_u8_##suffix, Isa::isa};
#include "kernels/warp_vote.inc"
#undef EGOFOCUS_WARP_VOTE
  return {};
}

ChosenConvU8S8 select_conv_u8s8(IsaSet allowed) noexcept {
#define EGOFOCUS_CONV_U8S8(suffix, isa, tile_outputs, group_inputs) \
  if (has_isa(allowed, Isa::isa)) return {{&conv_u8s8_##suffix, Isa::isa}, kConvPacking_##suffix};
#include "kernels/conv_u8s8.inc"
#undef EGOFOCUS_CONV_U8S8
  return {};
}

}  // namespace

KernelTable select_kernels(IsaSet allowed) noexcept {
  const IsaSet with_scalar = allowed | isa_bit(Isa::kScalar);
  KernelTable table;
  table.warp_vote = select_warp_vote(with_scalar);
  table.conv_u8s8 = select_conv_u8s8(with_scalar);
  return table;
}

}  // namespace egofocus
