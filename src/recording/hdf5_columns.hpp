// What the two HDF5 layouts share: times, and walking long data sets in blocks.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "recording/error.hpp"
#include "recording/hdf5_file.hpp"

namespace egofocus::recording {

inline constexpr std::size_t kBlockRows = 1u << 16;
/// No time: it counts as malformed, or is dropped, wherever it stands.
inline constexpr std::int64_t kNoTimeUs = INT64_MIN;

/// To the nearest microsecond; kNoTimeUs for what is not finite or beyond 30,000 years.
inline std::int64_t microseconds_of(double seconds) {
  return std::abs(seconds) < 1e12 ? std::llround(seconds * 1e6) : kNoTimeUs;
}

/// A short data set of seconds, whole.
inline std::vector<std::int64_t> read_times(const Hdf5File& file, const std::string& name) {
  const Hdf5Dataset set = file.dataset(name, 1, Hdf5Type::kFloat);
  if (set.rows() > 100'000'000) throw Error(ExitCode::kBadFile, set.where(), "has more rows than can be.");
  std::vector<double> seconds(static_cast<std::size_t>(set.rows()));
  set.read(0, seconds.size(), seconds);
  std::vector<std::int64_t> times;
  for (const double value : seconds) times.push_back(microseconds_of(value));
  return times;
}

/// Throws when the rows of a data set and its times do not pair.
inline void require_pairs(const Hdf5Dataset& set, std::size_t times) {
  if (set.rows() == times) return;
  throw Error(ExitCode::kBadFile, set.where(),
              "has " + std::to_string(set.rows()) + " rows, but there are " + std::to_string(times) +
                  " times for them. Is the file whole?");
}

/// work(first, count) for blocks of at most `block` rows.
template <typename Work>
void for_blocks(std::uint64_t rows, std::size_t block, const Work& work) {
  for (std::uint64_t first = 0; first < rows;) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(block, rows - first));
    work(first, count);
    first += count;
  }
}

}  // namespace egofocus::recording
