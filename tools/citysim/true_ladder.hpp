// The parallax ladder that the library would choose if it knew the motion exactly.
#pragma once

#include <cstdint>

#include "citysim/world.hpp"
#include "pipeline/hypothesis_ladder.hpp"

namespace egofocus::citysim {

inline constexpr std::int64_t kLongestWindowUs = WindowConfig{}.max_age_us;

/// A ladder with this much parallax is called full.
inline constexpr double kFullParallax_px = 0.9 * LadderConfig{}.span_px;

/// Of a window that ends at `end_us`, with the defaults of LadderConfig but for the world's z_near.
[[nodiscard]] HypothesisLadder true_ladder(const World& world, std::int64_t end_us);

}  // namespace egofocus::citysim
