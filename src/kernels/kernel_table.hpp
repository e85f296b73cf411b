// The kernels in use: one function pointer per op, filled once at set-up, read only afterwards.
#pragma once

#include "kernels/isa.hpp"
#include "kernels/warp_vote.hpp"

namespace egofocus {

/// An op and the variant of it that was chosen (for logs, health and tests).
template <class Function>
struct ChosenKernel {
  Function* run = nullptr;
  Isa isa = Isa::kScalar;
};

struct KernelTable {
  ChosenKernel<WarpVoteFunction> warp_vote;
};

/// The best compiled variant of each op among `allowed`, the scalar one where there is no other. Pass
/// `detect_isa() & mask`: a set that the machine does not have ends in an illegal instruction.
/// Thread: any. RT: set-up only.
KernelTable select_kernels(IsaSet allowed) noexcept;

}  // namespace egofocus
