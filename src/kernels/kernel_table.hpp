// The kernels in use: one function pointer per op, filled once at set-up, read only afterwards.
#pragma once

#include <span>

#include "kernels/conv_u8s8.hpp"
#include "kernels/depthwise_u8s8.hpp"
#include "kernels/isa.hpp"
#include "kernels/warp_vote.hpp"

namespace egofocus {

/// An op and the variant of it that was chosen (for logs, health and tests).
template <class Function>
struct ChosenKernel {
  Function* run = nullptr;
  Isa isa = Isa::kScalar;
};

/// The packing is the variant's own: weights packed for another one give wrong sums.
struct ChosenConvU8S8 : ChosenKernel<ConvU8S8Function> {
  ConvPacking packing;
};

struct ChosenDepthwiseU8S8 : ChosenKernel<DepthwiseU8S8Function> {
  DepthwisePacking packing;
};

struct KernelTable {
  ChosenKernel<WarpVoteFunction> warp_vote;
  ChosenConvU8S8 conv_u8s8;
  ChosenDepthwiseU8S8 depthwise_u8s8;
};

/// The best compiled variant of each op among `allowed`, the scalar one where there is no other. Pass
/// `detect_isa() & mask`: a set that the machine does not have ends in an illegal instruction.
/// Thread: any. RT: set-up only.
KernelTable select_kernels(IsaSet allowed) noexcept;

/// The ops of a backend and their instruction sets, as text: "warp_vote avx2, conv_u8s8 avxvnni". Writes at
/// most out.size() - 1 characters and a final NUL. Thread: any. RT: yes.
void name_kernels(const KernelTable& table, bool with_network, std::span<char> out) noexcept;

}  // namespace egofocus
