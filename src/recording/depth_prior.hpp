// What can be said about depth without looking at the picture: one constant, or one depth per row of the
// grid. Every method should beat them. Fitted on training recordings, kept in a small TOML file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "recording/depth_metrics.hpp"
#include "recording/picture.hpp"

namespace egofocus::recording {

/// The median of many truth pictures, counted value by value.
class TruthMedian {
 public:
  /// Pixels that are no truth within the range are left out.
  void add(const Picture<float>& truth_m, const MetricRange& range);
  /// Upper median; 0 when nothing was added.
  [[nodiscard]] double median_m() const;

 private:
  std::unordered_map<float, std::uint64_t> counts_;
};

struct DepthPrior {
  double median_m = 0;
  /// 1 / (mean inverse depth) of each grid row, top row first; a row without truth has that of the nearest
  /// row with truth, the upper one of two.
  std::vector<double> row_depth_m;
  std::size_t images = 0;
};

class DepthPriorFit {
 public:
  /// All pictures must be equally high. Throws Error (kConfiguration) otherwise.
  void add(const Picture<float>& truth_m, const MetricRange& range);
  /// Throws Error (kBadFile) when no picture had any truth.
  [[nodiscard]] DepthPrior result() const;

 private:
  struct Row {
    double inverse_sum = 0;
    std::uint64_t count = 0;
  };
  TruthMedian median_;
  std::vector<Row> rows_;
  std::size_t images_ = 0;
};

void write_prior(const std::filesystem::path& path, const DepthPrior& prior);

/// Throws Error: kFile, kBadFile (no TOML, a key missing, a depth that is not positive and finite).
[[nodiscard]] DepthPrior read_prior(const std::filesystem::path& path);

}  // namespace egofocus::recording
