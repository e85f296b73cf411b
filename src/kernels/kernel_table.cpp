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

}  // namespace

KernelTable select_kernels(IsaSet allowed) noexcept {
  const IsaSet with_scalar = allowed | isa_bit(Isa::kScalar);
  KernelTable table;
  table.warp_vote = select_warp_vote(with_scalar);
  return table;
}

}  // namespace egofocus
