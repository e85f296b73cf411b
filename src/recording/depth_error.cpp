#include "recording/depth_error.hpp"

#include <algorithm>
#include <cassert>
#include <vector>

namespace egofocus::recording {

DepthError depth_error(std::span<const float> estimate_m, std::span<const float> truth_m,
                       std::span<const std::uint8_t> mask) {
  assert(estimate_m.size() == truth_m.size() && (mask.empty() || mask.size() == truth_m.size()));
  DepthError result;
  std::vector<double> errors;
  double sum = 0;
  std::size_t near_ones = 0;
  std::size_t d1_ones = 0;
  for (std::size_t i = 0; i < truth_m.size(); ++i) {
    if (!is_truth(truth_m[i]) || (!mask.empty() && mask[i] == 0)) continue;
    ++result.truth_px;
    if (!(estimate_m[i] > 0)) continue;
    const double truth = static_cast<double>(truth_m[i]);
    const double estimate = static_cast<double>(std::min(estimate_m[i], kFarthestTruthM));
    const double error = (estimate > truth ? estimate - truth : truth - estimate) / truth;
    errors.push_back(error);
    sum += error;
    if (error <= 0.1) ++near_ones;
    if (std::max(estimate / truth, truth / estimate) < 1.25) ++d1_ones;
  }
  result.compared_px = errors.size();
  if (result.truth_px == 0 || errors.empty()) return result;
  const auto count = static_cast<double>(errors.size());
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  result.coverage = count / static_cast<double>(result.truth_px);
  result.median = *middle;
  result.abs_rel = sum / count;
  result.within_10_percent = static_cast<double>(near_ones) / count;
  result.d1 = static_cast<double>(d1_ones) / count;
  return result;
}

}  // namespace egofocus::recording
