// The ray tables of the cameras seen last: undistorting a sensor takes longer than stacking its events.
#pragma once

#include <array>
#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "egofocus/config.hpp"
#include "pipeline/working_grid.hpp"

namespace egofocus::training {

/// Thread: any.
class RayCache {
 public:
  using Rays = std::shared_ptr<const std::vector<Ray>>;

  /// As fill_rays() makes it. Throws recording::Error (kConfiguration) for what check_config() refuses.
  [[nodiscard]] Rays rays(const Config& config);

  /// At most so many bytes are kept; at least the table used last.
  void keep(std::size_t bytes);

 private:
  using Key = std::array<double, 12>;  // size, pinhole, distortion
  struct Entry {
    Rays rays;
    std::list<Key>::iterator age;
  };
  static Key key_of(const CameraModel& camera);
  void forget();

  std::mutex mutex_;
  std::map<Key, Entry> entries_;
  std::list<Key> used_;  // newest first
  std::size_t bytes_ = 0;
  std::size_t most_bytes_ = std::size_t{256} << 20;
};

}  // namespace egofocus::training
