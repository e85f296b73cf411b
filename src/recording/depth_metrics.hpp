// The accuracy metrics and their definitions. docs/accuracy.md repeats them for users.
//
// g: truth in metres; valid where 0 < g <= cut. d: the estimate in metres, clipped to [clip_min, clip_max]; a
// pixel without an estimate counts as infinity, which is what inverse depth 0 says, so as clip_max.
// p: the estimate as the paper's published evaluation takes it: not clipped, and 0 where it is above 100 m
// (so also at infinity and without an estimate). Each metric is a mean over the pixels of one image; figures
// of many images are means over images.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace egofocus::recording {

enum Metric : std::size_t {
  kAbsRel,         ///< mean |d - g| / g
  kSqRel,          ///< mean (d - g)^2 / g, metres
  kRmse,           ///< square root of mean (d - g)^2, metres
  kRmseLog,        ///< square root of mean (ln d - ln g)^2
  kD1,             ///< share of max(d / g, g / d) < 1.25
  kD2,             ///< ... < 1.25^2
  kD3,             ///< ... < 1.25^3
  kEpe,            ///< mean |d - g|, metres
  kMae10m,         ///< mean |d - g| where g < 10 m
  kMae20m,         ///< ... where g < 20 m
  kMae30m,         ///< ... where g < 30 m
  kIndexMae,       ///< mean |1/d - 1/g| / step, in steps of the tick's ladder; images without a ladder: none
  kPaperAbsRel,    ///< mean |p - g| / g: at most 1 where p is 0
  kPaperSqRel,     ///< mean (p - g)^2 / g^2
  kPaperRmse,      ///< square root of mean (p - g)^2
  kPaperRmseLog,   ///< as kRmseLog, over the pixels with p > 0 alone: a 0 has no logarithm
  kPaperD1,        ///< as kD1; p = 0 is outside
  kPaperD2,        ///< as kD2
  kPaperD3,        ///< as kD3
  kPaperEpe,       ///< mean |p - g|
  kPaperMae10m,    ///< mean |p - g| where g < 10 m
  kPaperMae20m,    ///< ... where g < 20 m
  kPaperMae30m,    ///< ... where g < 30 m
  kPaperZeroShare  ///< share of p = 0
};
inline constexpr std::size_t kMetrics = 24;

/// Keys in JSON, in the order of Metric.
inline constexpr std::array<const char*, kMetrics> kMetricNames = {"abs_rel",
                                                                   "sq_rel",
                                                                   "rmse",
                                                                   "rmse_log",
                                                                   "d1",
                                                                   "d2",
                                                                   "d3",
                                                                   "epe",
                                                                   "mae_10m",
                                                                   "mae_20m",
                                                                   "mae_30m",
                                                                   "idx_mae",
                                                                   "paper_abs_rel",
                                                                   "paper_sq_rel",
                                                                   "paper_rmse",
                                                                   "paper_rmse_log",
                                                                   "paper_d1",
                                                                   "paper_d2",
                                                                   "paper_d3",
                                                                   "paper_epe",
                                                                   "paper_mae_10m",
                                                                   "paper_mae_20m",
                                                                   "paper_mae_30m",
                                                                   "paper_zero_share"};

/// One number per metric; NaN: nothing to average.
using Metrics = std::array<double, kMetrics>;

/// Estimates above it are 0 in the paper_ metrics.
inline constexpr double kPaperFarthest_m = 100.0;

struct MetricRange {
  double cut_m = 80.0;
  double clip_min_m = 0.1;
  double clip_max_m = 80.0;

  [[nodiscard]] bool is_truth(double truth_m) const { return truth_m > 0 && truth_m <= cut_m; }
};

/// Means of metrics, each over the entries that have it.
class MetricMeans {
 public:
  void add(const Metrics& values);
  void add(const MetricMeans& other);
  /// NaN where nothing was added.
  [[nodiscard]] Metrics mean() const;
  /// Entries added.
  [[nodiscard]] std::size_t count() const { return entries_; }

 private:
  std::array<double, kMetrics> sums_{};
  std::array<std::size_t, kMetrics> counts_{};
  std::size_t entries_ = 0;
};

/// What one pixel adds to its image: the metric's term, before the root. `estimate_m`: 0 is no estimate,
/// infinity is one. Precondition: range.is_truth(truth_m). step_per_m 0: no ladder.
[[nodiscard]] Metrics pixel_terms(double estimate_m, double truth_m, const MetricRange& range,
                                  double step_per_m);

/// Of the means of pixel_terms(): takes the roots.
[[nodiscard]] Metrics image_metrics(const MetricMeans& terms);

}  // namespace egofocus::recording
