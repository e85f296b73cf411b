#include "vote_load.hpp"

#include <cmath>
#include <random>

namespace egofocus::bench {
namespace {

constexpr std::int32_t kWidth = 346;
constexpr std::int32_t kHeight = 260;
constexpr std::int32_t kHypotheses = 64;
constexpr std::size_t kEvents = 80000;
constexpr double kParallax = 24.0;  // px over the window, at the last hypothesis

std::int32_t q16(double px) {
  return static_cast<std::int32_t>(std::lround(px * 65536.0));
}

/// The grid cell of event i under hypothesis k, -1 outside.
std::int32_t cell_of(const WarpVote& vote, std::size_t i, std::int32_t k) {
  const std::int32_t column = (vote.u_q16[i] + k * vote.du_q16[i] + 0x8000) >> 16;
  const std::int32_t row = (vote.v_q16[i] + k * vote.dv_q16[i] + 0x8000) >> 16;
  const bool lands = column >= 0 && column < kWidth && row >= 0 && row < kHeight;
  return lands ? row * kWidth + column : -1;
}

}  // namespace

VoteLoad::VoteLoad(EventPattern pattern)
    : k_end_(kEvents, kHypotheses),
      stack_(static_cast<std::size_t>(kWidth) * kHeight * kHypotheses),
      scratch_(static_cast<std::size_t>(kWidth) * kHeight) {
  constexpr std::uint32_t kSeed = 1;
  pattern == EventPattern::kEdges ? add_edges(kSeed) : add_uniform(kSeed);
}

void VoteLoad::add_edges(std::uint32_t seed) {
  struct Segment {
    double x, y, dx, dy, parallax;
  };
  std::mt19937 random(seed);
  const auto real = [&random](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  std::vector<Segment> segments(60);
  for (Segment& s : segments) {
    const double angle = real(0.0, 6.28);
    const double length = real(20.0, 120.0);
    s = {real(10, kWidth - 10), real(10, kHeight - 10), length * std::cos(angle), length * std::sin(angle),
         real(0.1, 1.0) * kParallax};
  }
  for (std::size_t i = 0; i < kEvents; ++i) {
    const double age = 1.0 - static_cast<double>(i) / kEvents;
    const Segment& s = segments[random() % segments.size()];
    const double along = real(0.0, 1.0);
    u_.push_back(q16(s.x + along * s.dx - s.parallax * age + real(-0.4, 0.4)));
    v_.push_back(q16(s.y + along * s.dy + real(-0.4, 0.4)));
    du_.push_back(q16(kParallax * age / (kHypotheses - 1)));
    dv_.push_back(0);
  }
}

void VoteLoad::add_uniform(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto real = [&random](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  for (std::size_t i = 0; i < kEvents; ++i) {
    u_.push_back(q16(real(0, kWidth)));
    v_.push_back(q16(real(0, kHeight)));
    const double angle = real(0.0, 6.28);
    const double step = real(0.0, kParallax) / (kHypotheses - 1);
    du_.push_back(q16(step * std::cos(angle)));
    dv_.push_back(q16(step * std::sin(angle)));
  }
}

WarpVote VoteLoad::vote() {
  WarpVote vote;
  vote.u_q16 = u_.data();
  vote.v_q16 = v_.data();
  vote.du_q16 = du_.data();
  vote.dv_q16 = dv_.data();
  vote.k_end = k_end_.data();
  vote.n = static_cast<std::int32_t>(kEvents);
  vote.k_count = kHypotheses;
  vote.width = kWidth;
  vote.height = kHeight;
  vote.row_stride = kWidth;
  vote.plane_stride = kWidth * kHeight;
  vote.stack = stack_.data();
  vote.scratch = scratch_.data();
  return vote;
}

VoteBound::VoteBound(const WarpVote& vote) : votes_(kHypotheses), runs_(kHypotheses / 4) {
  for (std::int32_t k = 0; k < kHypotheses; ++k) {
    for (std::size_t i = 0; i < kEvents; ++i) {
      const std::int32_t cell = cell_of(vote, i, k);
      if (cell >= 0) votes_[static_cast<std::size_t>(k)].push_back(static_cast<std::uint32_t>(cell));
    }
  }
  for (std::int32_t group = 0; group < kHypotheses / 4; ++group) {
    for (std::size_t i = 0; i < kEvents; ++i) {
      std::int32_t previous = -1;
      for (std::int32_t k = 4 * group; k < 4 * group + 4; ++k) {
        const std::int32_t cell = cell_of(vote, i, k);
        if (cell >= 0 && cell != previous) {
          runs_[static_cast<std::size_t>(group)].push_back(static_cast<std::uint32_t>(cell));
        }
        previous = cell;
      }
    }
  }
}

void VoteBound::run_votes(const WarpVote& vote) const {
  std::uint8_t* plane = vote.stack;
  for (const std::vector<std::uint32_t>& cells : votes_) {
    for (std::uint32_t cell : cells)
      plane[cell] = static_cast<std::uint8_t>(plane[cell] + (plane[cell] != 255));
    plane += vote.plane_stride;
  }
}

void VoteBound::run_runs(const WarpVote& vote) const {
  for (const std::vector<std::uint32_t>& cells : runs_) {
    for (std::uint32_t cell : cells) vote.scratch[cell] += 0x01010101u;
  }
}

}  // namespace egofocus::bench
