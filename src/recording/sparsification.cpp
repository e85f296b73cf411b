#include "recording/sparsification.hpp"

#include <algorithm>
#include <cassert>
#include <vector>

namespace egofocus::recording {
namespace {

std::size_t remaining(std::size_t n, int step) {
  return n - n * static_cast<std::size_t>(step) / kSparsificationSteps;
}

/// Pixels of one confidence.
struct Level {
  std::size_t count = 0;
  double sum = 0;
};

double mean_of_most_confident(const std::array<Level, 256>& levels, std::size_t keep) {
  std::size_t left = keep;
  double sum = 0;
  for (std::size_t c = levels.size(); c-- > 0 && left > 0;) {
    const Level& level = levels[c];
    if (level.count == 0) continue;
    const std::size_t taken = std::min(left, level.count);
    sum += level.sum * (static_cast<double>(taken) / static_cast<double>(level.count));
    left -= taken;
  }
  return sum / static_cast<double>(keep);
}

void add_to(SparsificationCurve& sum, const SparsificationCurve& curve) {
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += curve[k];
}

}  // namespace

Sparsification sparsification(std::span<const JudgedPixel> pixels) {
  assert(!pixels.empty());
  std::array<Level, 256> levels{};
  std::vector<double> errors;
  errors.reserve(pixels.size());
  for (const JudgedPixel& pixel : pixels) {
    ++levels[pixel.confidence].count;
    levels[pixel.confidence].sum += pixel.error;
    errors.push_back(pixel.error);
  }
  std::sort(errors.begin(), errors.end());
  Sparsification result;
  std::size_t summed = 0;
  double sum = 0;
  for (int k = kSparsificationSteps - 1; k >= 0; --k) {
    const std::size_t keep = remaining(pixels.size(), k);
    while (summed < keep) sum += errors[summed++];
    result.by_oracle[static_cast<std::size_t>(k)] = sum / static_cast<double>(keep);
    result.by_confidence[static_cast<std::size_t>(k)] = mean_of_most_confident(levels, keep);
  }
  return result;
}

double area_under(const SparsificationCurve& curve) {
  double area = 0;
  for (std::size_t k = 1; k < curve.size(); ++k) area += 0.5 * (curve[k - 1] + curve[k]);
  return area / kSparsificationSteps;
}

void SparsificationMeans::add(const Sparsification& image) {
  add_to(sums_.by_confidence, image.by_confidence);
  add_to(sums_.by_oracle, image.by_oracle);
  ++images_;
}

void SparsificationMeans::add(const SparsificationMeans& other) {
  add_to(sums_.by_confidence, other.sums_.by_confidence);
  add_to(sums_.by_oracle, other.sums_.by_oracle);
  images_ += other.images_;
}

Sparsification SparsificationMeans::mean() const {
  Sparsification mean = sums_;
  if (images_ == 0) return mean;
  for (SparsificationCurve* curve : {&mean.by_confidence, &mean.by_oracle}) {
    for (double& value : *curve) value /= static_cast<double>(images_);
  }
  return mean;
}

}  // namespace egofocus::recording
