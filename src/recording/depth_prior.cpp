#include "recording/depth_prior.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "recording/error.hpp"
#include "recording/number_text.hpp"
#include "recording/text_file.hpp"

namespace egofocus::recording {
namespace {

constexpr std::size_t kMaxRows = 16384;

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& what) {
  throw Error(ExitCode::kBadFile, path.string(),
              what + " Make it with `egofocus eval --fit-prior FILE RECORDING...`.");
}

double depth_of(const toml::node_view<const toml::node>& node, const std::filesystem::path& path,
                const std::string& key) {
  const auto value = node.value<double>();
  if (!value || !std::isfinite(*value) || !(*value > 0))
    refuse(path, "`" + key + "` must be metres above 0.");
  return *value;
}

}  // namespace

void TruthMedian::add(const Picture<float>& truth_m, const MetricRange& range) {
  for (const float value : truth_m.pixels) {
    if (range.is_truth(static_cast<double>(value))) ++counts_[value];
  }
}

double TruthMedian::median_m() const {
  std::vector<std::pair<float, std::uint64_t>> sorted(counts_.begin(), counts_.end());
  std::sort(sorted.begin(), sorted.end());
  std::uint64_t all = 0;
  for (const auto& [value, count] : sorted) all += count;
  std::uint64_t below = 0;
  for (const auto& [value, count] : sorted) {
    below += count;
    if (below > all / 2) return static_cast<double>(value);
  }
  return 0;
}

void DepthPriorFit::add(const Picture<float>& truth_m, const MetricRange& range) {
  const auto height = static_cast<std::size_t>(truth_m.height_px);
  if (rows_.empty()) rows_.resize(height);
  if (rows_.size() != height) {
    throw Error(ExitCode::kConfiguration, "--fit-prior",
                "the recordings have grids of " + std::to_string(rows_.size()) + " and " +
                    std::to_string(height) + " rows. Fit one prior per grid.");
  }
  median_.add(truth_m, range);
  ++images_;
  const auto width = static_cast<std::size_t>(truth_m.width_px);
  for (std::size_t i = 0; i < truth_m.pixels.size(); ++i) {
    const double depth = static_cast<double>(truth_m.pixels[i]);
    if (!range.is_truth(depth)) continue;
    rows_[i / width].inverse_sum += 1.0 / depth;
    ++rows_[i / width].count;
  }
}

DepthPrior DepthPriorFit::result() const {
  DepthPrior prior;
  prior.median_m = median_.median_m();
  prior.images = images_;
  if (!(prior.median_m > 0)) {
    throw Error(ExitCode::kBadFile, "--fit-prior",
                "none of the depth pictures holds any truth in range. Give recordings with depth/*.png.");
  }
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    std::size_t from = row;
    for (std::size_t away = 0; rows_[from].count == 0; ++away) {
      if (row >= away && rows_[row - away].count > 0)
        from = row - away;
      else if (row + away < rows_.size() && rows_[row + away].count > 0)
        from = row + away;
    }
    prior.row_depth_m.push_back(static_cast<double>(rows_[from].count) / rows_[from].inverse_sum);
  }
  return prior;
}

void write_prior(const std::filesystem::path& path, const DepthPrior& prior) {
  std::string rows;
  for (const double depth : prior.row_depth_m) rows += (rows.empty() ? "" : ", ") + number_text(depth);
  write_text_file(path, "# Depth without looking: see docs/accuracy.md. Metres.\nimages = " +
                            std::to_string(prior.images) + "\nmedian_m = " + number_text(prior.median_m) +
                            "\nrow_depth_m = [" + rows + "]\n");
}

DepthPrior read_prior(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  toml::table root;
  try {
    root = toml::parse(text, path.string());
  } catch (const toml::parse_error& error) {
    refuse(path, "is no valid TOML: " + std::string(error.description()) + ".");
  }
  const toml::table& table = root;
  DepthPrior prior;
  prior.median_m = depth_of(table["median_m"], path, "median_m");
  prior.images =
      static_cast<std::size_t>(std::max<std::int64_t>(table["images"].value_or(std::int64_t{0}), 0));
  const toml::array* rows = table["row_depth_m"].as_array();
  if (!rows || rows->empty() || rows->size() > kMaxRows)
    refuse(path, "`row_depth_m` must be a list of depths.");
  for (const toml::node& row : *rows)
    prior.row_depth_m.push_back(depth_of(toml::node_view<const toml::node>(row), path, "row_depth_m"));
  return prior;
}

}  // namespace egofocus::recording
