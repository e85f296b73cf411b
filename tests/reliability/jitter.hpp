// How late a loop that wakes at fixed times did wake: percentiles, histogram, misses.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "recording/json.hpp"

namespace egofocus::reliability {

class Jitter {
 public:
  /// A wake-up later than this is a miss, as the engine's own kLateTick.
  static constexpr std::int64_t kMiss_ns = 1'000'000;

  /// No memory is taken for the first `count`.
  explicit Jitter(std::size_t count) : late_ns_(count, 0) { late_ns_.clear(); }

  void add(std::int64_t late_ns) { late_ns_.push_back(late_ns); }
  /// Deadlines at which the loop did not begin at all.
  void skip(std::uint64_t count) { skipped_ += count; }

  [[nodiscard]] double misses_percent() const {
    const auto late = static_cast<std::uint64_t>(
        std::count_if(late_ns_.begin(), late_ns_.end(), [](std::int64_t ns) { return ns > kMiss_ns; }));
    return 100.0 * static_cast<double>(late + skipped_) / static_cast<double>(late_ns_.size() + skipped_);
  }
  /// `share` 0..1; microseconds.
  [[nodiscard]] double percentile_us(double share) const {
    std::vector<std::int64_t> sorted = late_ns_;
    std::sort(sorted.begin(), sorted.end());
    const auto last = static_cast<double>(sorted.size() - 1);
    return static_cast<double>(sorted[static_cast<std::size_t>(share * last + 0.5)]) * 1e-3;
  }

  [[nodiscard]] recording::Json json() const {
    recording::Json out;
    out.add("wake_ups", late_ns_.size()).add("skipped", skipped_).add("misses_percent", misses_percent());
    out.add("p50_us", percentile_us(0.5))
        .add("p99_9_us", percentile_us(0.999))
        .add("max_us", percentile_us(1));
    return out.add("up_to_us", std::span<const double>(bounds()))
        .add("count", std::span<const double>(counts()));
  }

  /// One line per class of lateness, each twice as wide as the one before.
  static void print(const Jitter& one, const char* name, const Jitter& other, const char* other_name) {
    const std::vector<double> bounds_us = bounds();
    const std::vector<double> a = one.counts();
    const std::vector<double> b = other.counts();
    std::printf("%12s %10s %10s\n", "late by, us", name, other_name);
    for (std::size_t i = 0; i < bounds_us.size(); ++i) {
      if (a[i] == 0 && b[i] == 0) continue;
      std::printf("%12s %10.0f %10.0f\n", label(i).c_str(), a[i], b[i]);
    }
  }

 private:
  static constexpr int kClasses = 18;  // up to 65 ms, and beyond
  static std::vector<double> bounds() {
    std::vector<double> all;
    for (int i = 0; i < kClasses; ++i) all.push_back(static_cast<double>(1 << i));
    return all;
  }
  static std::string label(std::size_t i) {
    return i + 1 < kClasses ? "<= " + std::to_string(1 << i) : "more";
  }
  [[nodiscard]] std::vector<double> counts() const {
    std::vector<double> all(kClasses, 0);
    for (const std::int64_t ns : late_ns_) {
      std::size_t i = 0;
      while (i + 1 < kClasses && ns > (std::int64_t{1000} << i)) ++i;
      ++all[i];
    }
    return all;
  }

  std::vector<std::int64_t> late_ns_;
  std::uint64_t skipped_ = 0;
};

}  // namespace egofocus::reliability
