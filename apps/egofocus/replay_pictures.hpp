// The pictures of a replay: per tick events, depth and confidence; at the end one overview of the whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "egofocus/types.hpp"
#include "recording/picture.hpp"

namespace egofocus::app {

class ReplayPictures {
 public:
  /// Makes the folder; an earlier replay's overview.png and report.json go: what comes last says that the
  /// folder is whole. `z_near_m` is where the depth colours end. Throws recording::Error.
  ReplayPictures(std::filesystem::path folder, double z_near_m);

  /// <t_us>_events.png, _depth.png, _confidence.png, and _focus.png where there is another backend's frame
  /// `beside`. `truth_m` is empty or as large as the grid. Frames with depth are candidates for the overview.
  void write(const DepthFrame& frame, const DepthFrame* beside, const Intrinsics& sensor,
             std::span<const Event> events, std::span<const float> truth_m);

  /// overview.png: a row of events, depth, confidence, the depth beside and truth for up to kOverviewRows
  /// ticks, evenly chosen among those with depth. Nothing when no tick had depth.
  void write_overview() const;

 private:
  static constexpr std::size_t kOverviewRows = 4;

  std::filesystem::path folder_;
  double z_near_m_;
  std::vector<recording::RgbPicture> rows_;  // small: thinned out as they come
  std::size_t seen_ = 0;
  std::size_t stride_ = 1;
};

}  // namespace egofocus::app
