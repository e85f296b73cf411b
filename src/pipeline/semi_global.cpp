#include "pipeline/semi_global.hpp"

namespace egofocus {
namespace {

constexpr std::int16_t kGuard = 16384;  // never the smallest, and kGuard + P2 still fits

// One step of a path: from L(p', .) with its minimum to L(p, .). `before` and `after` have a guard on both
// sides. Returns min_k L(p, k). `add` says whether the sums already hold another path.
std::int16_t step(const std::uint8_t* penalty, const std::int16_t* before, std::int16_t before_min,
                  std::int16_t* after, std::int16_t* sums, std::int32_t hypotheses, bool add) noexcept {
  const auto jump = static_cast<std::int16_t>(before_min + SemiGlobal::kLargeStep);
  std::int16_t smallest = kGuard;
  for (std::int32_t k = 0; k < hypotheses; ++k) {
    const std::int16_t left = before[k - 1];
    const std::int16_t right = before[k + 1];
    const auto beside = static_cast<std::int16_t>((left < right ? left : right) + SemiGlobal::kSmallStep);
    std::int16_t best = before[k] < beside ? before[k] : beside;
    best = best < jump ? best : jump;
    const auto value = static_cast<std::int16_t>(penalty[k] + best - before_min);
    after[k] = value;
    smallest = smallest < value ? smallest : value;
  }
  if (add) {
    for (std::int32_t k = 0; k < hypotheses; ++k) sums[k] = static_cast<std::int16_t>(sums[k] + after[k]);
  } else {
    for (std::int32_t k = 0; k < hypotheses; ++k) sums[k] = after[k];
  }
  return smallest;
}

}  // namespace

SemiGlobal::SemiGlobal(CellGrid cells, std::int32_t hypotheses, int parts, Arena& arena) noexcept
    : cells_(cells), hypotheses_(hypotheses) {
  const auto depth = static_cast<std::size_t>(hypotheses);
  const auto across = static_cast<std::size_t>(cells.width);
  sums_ = arena.array<std::int16_t>(cells.size() * depth);
  for (int i = 0; i < parts; ++i) {
    states_[i].previous = arena.array<std::int16_t>(across * (depth + 2));
    states_[i].next = arena.array<std::int16_t>(depth + 2);
    states_[i].smallest = arena.array<std::int16_t>(across);
  }
}

void SemiGlobal::along_rows(std::span<const std::uint8_t> penalty, int part, int parts) noexcept {
  const auto depth = static_cast<std::size_t>(hypotheses_);
  std::int16_t* a = states_[part].previous.data() + 1;
  std::int16_t* b = states_[part].next.data() + 1;
  for (std::int32_t y = cells_.height * part / parts; y < cells_.height * (part + 1) / parts; ++y) {
    for (const bool backwards : {false, true}) {
      std::int16_t smallest = 0;
      a[-1] = a[depth] = b[-1] = b[depth] = kGuard;
      for (std::size_t k = 0; k < depth; ++k) a[k] = 0;
      for (std::int32_t i = 0; i < cells_.width; ++i) {
        const std::int32_t x = backwards ? cells_.width - 1 - i : i;
        const std::size_t at = (static_cast<std::size_t>(y) * static_cast<std::size_t>(cells_.width) +
                                static_cast<std::size_t>(x)) *
                               depth;
        smallest = step(penalty.data() + at, a, smallest, b, sums_.data() + at, hypotheses_, backwards);
        std::int16_t* swap = a;
        a = b;
        b = swap;
      }
    }
  }
}

void SemiGlobal::along_columns(std::span<const std::uint8_t> penalty, int part, int parts) noexcept {
  const auto depth = static_cast<std::size_t>(hypotheses_);
  const std::int32_t first = cells_.width * part / parts;
  const std::int32_t last = cells_.width * (part + 1) / parts;
  State& state = states_[part];
  std::int16_t* next = state.next.data() + 1;
  next[-1] = next[depth] = kGuard;
  for (const bool upwards : {false, true}) {
    for (std::int32_t x = first; x < last; ++x) {
      std::int16_t* previous = state.previous.data() + static_cast<std::size_t>(x - first) * (depth + 2) + 1;
      previous[-1] = previous[depth] = kGuard;
      for (std::size_t k = 0; k < depth; ++k) previous[k] = 0;
      state.smallest[static_cast<std::size_t>(x - first)] = 0;
    }
    for (std::int32_t i = 0; i < cells_.height; ++i) {
      const std::int32_t y = upwards ? cells_.height - 1 - i : i;
      for (std::int32_t x = first; x < last; ++x) {
        const std::size_t at = (static_cast<std::size_t>(y) * static_cast<std::size_t>(cells_.width) +
                                static_cast<std::size_t>(x)) *
                               depth;
        std::int16_t* previous =
            state.previous.data() + static_cast<std::size_t>(x - first) * (depth + 2) + 1;
        std::int16_t& smallest = state.smallest[static_cast<std::size_t>(x - first)];
        smallest = step(penalty.data() + at, previous, smallest, next, sums_.data() + at, hypotheses_, true);
        for (std::size_t k = 0; k < depth; ++k) previous[k] = next[k];
      }
    }
  }
}

}  // namespace egofocus
