#include "recording/depth_metrics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace egofocus::recording {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double inside(double ratio, double limit) {
  return ratio < limit ? 1.0 : 0.0;
}

/// Where the terms that both definitions share belong.
struct Common {
  Metric abs_rel, rmse, rmse_log, d1, d2, d3, epe, mae_10m, mae_20m, mae_30m;
};
constexpr Common kPlain{kAbsRel, kRmse, kRmseLog, kD1, kD2, kD3, kEpe, kMae10m, kMae20m, kMae30m};
constexpr Common kPaper{kPaperAbsRel, kPaperRmse, kPaperRmseLog, kPaperD1,     kPaperD2,
                        kPaperD3,     kPaperEpe,  kPaperMae10m,  kPaperMae20m, kPaperMae30m};

void fill(double d, double g, const Common& to, Metrics& terms) {
  const double error = std::abs(d - g);
  const double ratio = d > 0 ? std::max(d / g, g / d) : kInfinity;
  const double log_error = d > 0 ? std::log(d) - std::log(g) : kNothing;
  terms[to.abs_rel] = error / g;
  terms[to.rmse] = error * error;
  terms[to.rmse_log] = log_error * log_error;
  terms[to.d1] = inside(ratio, 1.25);
  terms[to.d2] = inside(ratio, 1.25 * 1.25);
  terms[to.d3] = inside(ratio, 1.25 * 1.25 * 1.25);
  terms[to.epe] = error;
  terms[to.mae_10m] = g < 10 ? error : kNothing;
  terms[to.mae_20m] = g < 20 ? error : kNothing;
  terms[to.mae_30m] = g < 30 ? error : kNothing;
}

}  // namespace

void MetricMeans::add(const Metrics& values) {
  for (std::size_t i = 0; i < kMetrics; ++i) {
    const bool is_there = values[i] == values[i];
    sums_[i] += is_there ? values[i] : 0.0;
    counts_[i] += is_there ? 1u : 0u;
  }
  ++entries_;
}

void MetricMeans::add(const MetricMeans& other) {
  for (std::size_t i = 0; i < kMetrics; ++i) {
    sums_[i] += other.sums_[i];
    counts_[i] += other.counts_[i];
  }
  entries_ += other.entries_;
}

Metrics MetricMeans::mean() const {
  Metrics means;
  for (std::size_t i = 0; i < kMetrics; ++i)
    means[i] = counts_[i] > 0 ? sums_[i] / static_cast<double>(counts_[i]) : kNothing;
  return means;
}

Metrics pixel_terms(double estimate_m, double truth_m, const MetricRange& range, double step_per_m) {
  assert(range.is_truth(truth_m));
  const double g = truth_m;
  const double claimed = estimate_m > 0 ? estimate_m : kInfinity;
  const double d = std::clamp(claimed, range.clip_min_m, range.clip_max_m);
  const double p = claimed > kPaperFarthest_m ? 0.0 : claimed;
  Metrics terms;
  fill(d, g, kPlain, terms);
  fill(p, g, kPaper, terms);
  terms[kSqRel] = (d - g) * (d - g) / g;
  terms[kIndexMae] = step_per_m > 0 ? std::abs(1.0 / d - 1.0 / g) / step_per_m : kNothing;
  terms[kPaperSqRel] = (p - g) * (p - g) / (g * g);
  terms[kPaperZeroShare] = p > 0 ? 0.0 : 1.0;
  return terms;
}

Metrics image_metrics(const MetricMeans& terms) {
  Metrics metrics = terms.mean();
  for (const Metric root : {kRmse, kRmseLog, kPaperRmse, kPaperRmseLog})
    metrics[root] = std::sqrt(metrics[root]);
  return metrics;
}

}  // namespace egofocus::recording
