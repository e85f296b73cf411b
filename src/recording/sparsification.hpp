// Does the confidence know where the depth is wrong? The error of what is left when the least confident
// pixels are removed, against an oracle that removes the worst ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace egofocus::recording {

/// Shares removed: 0, 5, ... 95 %.
inline constexpr int kSparsificationSteps = 20;
using SparsificationCurve = std::array<double, kSparsificationSteps>;

struct JudgedPixel {
  double error = 0;  ///< |d - g| / g
  std::uint8_t confidence = 0;
};

/// Of one image with n > 0 pixels: entry k is the mean error of the n - floor(n k / 20) pixels that remain.
struct Sparsification {
  /// The most confident remain. Among pixels of equal confidence the expectation over all orders is taken.
  SparsificationCurve by_confidence{};
  SparsificationCurve by_oracle{};  ///< the smallest errors remain
};

[[nodiscard]] Sparsification sparsification(std::span<const JudgedPixel> pixels);

/// Trapezoids from 0 to 95 % removed.
[[nodiscard]] double area_under(const SparsificationCurve& curve);

/// Mean curves of many images.
class SparsificationMeans {
 public:
  void add(const Sparsification& image);
  void add(const SparsificationMeans& other);
  [[nodiscard]] std::size_t images() const { return images_; }
  /// All zero before the first image.
  [[nodiscard]] Sparsification mean() const;

 private:
  Sparsification sums_;
  std::size_t images_ = 0;
};

}  // namespace egofocus::recording
