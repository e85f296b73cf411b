// How far a depth map is from the truth. The definitions of the README's numbers stand here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/types.hpp"

namespace egofocus::recording {

/// Truth beyond it is not looked at, and an estimate beyond it counts as this.
inline constexpr float kFarthestTruthM = 80.0f;

[[nodiscard]] constexpr bool is_truth(float truth_m) {
  return truth_m > 0 && truth_m <= kFarthestTruthM;
}

/// e = |d - g| / g over the pixels that have both truth g in (0, 80] m and an estimate d; depths beyond 80 m
/// count as 80 m. All zero where there is no such pixel.
struct DepthError {
  std::size_t truth_px = 0;      ///< pixels with truth
  std::size_t compared_px = 0;   ///< of them, pixels with an estimate
  double coverage = 0;           ///< compared_px / truth_px
  double median = 0;             ///< median of e (upper median)
  double abs_rel = 0;            ///< mean of e
  double within_10_percent = 0;  ///< share of e <= 0.1
  double d1 = 0;                 ///< share of max(d / g, g / d) < 1.25
};

/// Estimate and truth in metres, the same layout; 0 means unknown in both. With `mask` (same size), pixels
/// whose mask is 0 are left out altogether.
[[nodiscard]] DepthError depth_error(std::span<const float> estimate_m, std::span<const float> truth_m,
                                     std::span<const std::uint8_t> mask = {});

/// The same of a frame on the truth's grid, all pixels with an estimate, or only the `most_confident` ones
/// among the pixels that have truth (ties go to the smaller pixel index).
[[nodiscard]] DepthError frame_error(const DepthFrame& frame, std::span<const float> truth_m,
                                     std::size_t most_confident = SIZE_MAX);

}  // namespace egofocus::recording
