#include <algorithm>
#include <vector>

#include "recording/depth_error.hpp"

namespace egofocus::recording {

DepthError frame_error(const DepthFrame& frame, std::span<const float> truth_m, std::size_t most_confident) {
  std::vector<float> depth(truth_m.size(), 0.0f);
  metric_depth(frame, kFarthestTruthM, depth);
  std::vector<std::size_t> known;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (depth[i] > 0 && is_truth(truth_m[i])) known.push_back(i);
  }
  if (known.size() <= most_confident) return depth_error(depth, truth_m);
  std::stable_sort(known.begin(), known.end(), [&frame](std::size_t a, std::size_t b) {
    return frame.confidence[a] > frame.confidence[b];
  });
  std::vector<std::uint8_t> mask(depth.size(), 0);
  for (std::size_t i = 0; i < most_confident; ++i) mask[known[i]] = 1;
  return depth_error(depth, truth_m, mask);
}

}  // namespace egofocus::recording
