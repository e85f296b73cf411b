// For builds with EGOFOCUS_CHECK_KERNELS, which are for tests alone: every dispatched call beside its scalar
// meaning. Where a byte differs: kernel, instruction set and place on stderr, then abort(). The comparisons
// are tests/kernels/checked_kernels.cpp.
#pragma once

#include "kernels/conv_u8s8.hpp"
#include "kernels/depthwise_u8s8.hpp"
#include "kernels/isa.hpp"
#include "kernels/warp_vote.hpp"

namespace egofocus {

/// What `run` does, and what it returns. Thread: as the kernel. RT: no (they take heap).
std::int64_t check_warp_vote(WarpVoteFunction* run, Isa isa, const WarpVote& vote) noexcept;
void check_conv_u8s8(ConvU8S8Function* run, Isa isa, const ConvPacking& packing,
                     const ConvU8S8& conv) noexcept;
void check_depthwise_u8s8(DepthwiseU8S8Function* run, Isa isa, const DepthwisePacking& packing,
                          const DepthwiseU8S8& conv) noexcept;

/// The same as functions of the kernels' own types, for the table.
template <WarpVoteFunction* kRun, Isa kIsa>
std::int64_t checked_warp_vote(const WarpVote& vote) noexcept {
  return check_warp_vote(kRun, kIsa, vote);
}
template <ConvU8S8Function* kRun, Isa kIsa, ConvPacking kPacking>
void checked_conv_u8s8(const ConvU8S8& conv) noexcept {
  check_conv_u8s8(kRun, kIsa, kPacking, conv);
}
template <DepthwiseU8S8Function* kRun, Isa kIsa, DepthwisePacking kPacking>
void checked_depthwise_u8s8(const DepthwiseU8S8& conv) noexcept {
  check_depthwise_u8s8(kRun, kIsa, kPacking, conv);
}

}  // namespace egofocus
