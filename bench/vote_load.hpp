// Events for the vote benchmarks: 80,000 of them on a 346x260 grid with 64 hypotheses, and the memory for the
// votes.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/warp_vote.hpp"

namespace egofocus::bench {

enum class EventPattern {
  kEdges,    ///< 60 line segments at their own depths, moving sideways by up to 24 px over the window
  kUniform,  ///< anywhere, moving up to 24 px in any direction
};

class VoteLoad {
 public:
  explicit VoteLoad(EventPattern pattern);
  WarpVote vote();

 private:
  void add_edges(std::uint32_t seed);
  void add_uniform(std::uint32_t seed);

  std::vector<std::int32_t> u_, v_, du_, dv_;
  std::vector<std::uint8_t> k_end_;
  std::vector<std::uint8_t> stack_;
  std::vector<std::uint32_t> scratch_;
};

/// What memory alone costs: the same addresses in the same order, known beforehand, and added to.
class VoteBound {
 public:
  explicit VoteBound(const WarpVote& vote);
  /// One byte read, incremented (saturating) and written per vote.
  void run_votes(const WarpVote& vote) const;
  /// One 32-bit word read, added to and written per run of up to four hypotheses that share a cell.
  void run_runs(const WarpVote& vote) const;

 private:
  std::vector<std::vector<std::uint32_t>> votes_;  // [hypothesis]
  std::vector<std::vector<std::uint32_t>> runs_;   // [group of four]
};

}  // namespace egofocus::bench
