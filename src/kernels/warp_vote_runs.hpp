// What the x86 bodies of warp_vote share. An event moves by a fraction of a pixel from one hypothesis to
// the next, so neighbouring hypotheses mostly share a cell. They are taken four at a time into the scratch
// grid, whose u32 cell holds their four counts side by side; the walk of an event through a group of four is
// cut into runs (a cell, and the hypotheses that land on it), and a run costs one read-modify-write, whatever
// its length. Then the group is folded: transposed, and added to its four planes. Counts saturate to min(255,
// sum) in any order of adding, hence the bits of the scalar loop. A single vote at a time is bound by its
// read-modify-write at half the speed.
#pragma once

#include <cstdint>

#include "kernels/warp_vote.hpp"

namespace egofocus {

constexpr std::int32_t kVoteGroup = 4;    ///< hypotheses of a group
constexpr std::int32_t kVoteLane = 16;    ///< events per find_runs, columns per fold: multiples of this
constexpr std::int32_t kVoteBlock = 256;  ///< events whose runs are kept at once: 4 KiB of the first cache

/// A run: (row * width + column) << 4 | hypotheses of the group, one bit each. Negative: no cell.
constexpr std::int32_t kNoCell = -16;

/// Room for the runs of a block, and for whole vectors stored past the last of them.
constexpr std::int32_t kRunRoom = kVoteBlock * kVoteGroup + kVoteLane;

/// Not inline, as all constants here: an ISA object must define no weak symbol. Byte h of entry m counts
/// hypothesis h of the run's bits m.
constexpr std::uint32_t kRunCounts[16] = {
    0x00000000, 0x00000001, 0x00000100, 0x00000101, 0x00010000, 0x00010001, 0x00010100, 0x00010101,
    0x01000000, 0x01000001, 0x01000100, 0x01000101, 0x01010000, 0x01010001, 0x01010100, 0x01010101};

struct FoundRuns {
  std::int32_t runs;
  std::int32_t landed;
};

/// The steps that an instruction set brings. All counts of events and columns are multiples of kVoteLane.
struct VoteSteps {
  /// Events [first, first + count), count <= kVoteBlock; hypotheses [k_first, k_first + planes), planes 1..4.
  FoundRuns (*find_runs)(const WarpVote& vote, std::int32_t first, std::int32_t count, std::int32_t k_first,
                         std::int32_t planes, std::int32_t* runs) noexcept;
  /// scratch[run >> 4] += kRunCounts[run & 15], saturating per byte.
  void (*add_runs)(const std::int32_t* runs, std::int32_t count, std::uint32_t* scratch) noexcept;
  /// plane h [x] += byte h of cells[x], saturating, for h < planes; cells are cleared.
  void (*fold_row)(std::uint32_t* cells, std::int32_t columns, std::uint8_t* row, std::int64_t plane_stride,
                   std::int32_t planes) noexcept;
};

/// The whole op by these steps; what is left over of events and columns is done here.
/// Thread: as warp_vote. RT: yes.
std::int64_t warp_vote_by_runs(const WarpVote& vote, const VoteSteps& steps) noexcept;

}  // namespace egofocus
