// Samples on disk, in shards that appear whole or not at all: what is there is not made again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "citysim/world.hpp"

namespace egofocus::citysim {

struct SampleOptions {
  std::vector<Family> families;  ///< drawn from evenly; a name given twice counts twice
  int count = 1000;              ///< rounded up to whole shards
  std::uint64_t seed = 1;
  int width_px = 346;
  int height_px = 260;
  int threads = 2;
  std::function<void(int, int)> progress;  ///< shards done, shards in all
};

inline constexpr int kShardSamples = 64;
inline constexpr int kWorldSamples = 8;  ///< windows of one world

/// shard_000000.egs
[[nodiscard]] std::filesystem::path shard_path(const std::filesystem::path& folder, int shard);

/// Makes the shards that are missing; returns how many were made. Throws recording::Error: kFile when the
/// disk refuses, kUsage when the folder's shards were made with other arguments (samples.txt says which).
int fill_sample_cache(const SampleOptions& options, const std::filesystem::path& folder);

}  // namespace egofocus::citysim
