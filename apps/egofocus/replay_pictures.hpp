// The pictures of a replay: per tick events, depth and confidence.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "egofocus/types.hpp"

namespace egofocus::app {

class ReplayPictures {
 public:
  /// Makes the folder. `z_near_m` is where the depth colours end. Throws recording::Error.
  ReplayPictures(std::filesystem::path folder, double z_near_m);

  /// <t_us>_events.png, _depth.png, _confidence.png
  void write(const DepthFrame& frame, const Intrinsics& sensor, std::span<const Event> events) const;

 private:
  std::filesystem::path folder_;
  double z_near_m_;
};

}  // namespace egofocus::app
