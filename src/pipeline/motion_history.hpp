// The last second or more of camera motion, as the filter saw it when each sample came: piecewise linear in
// between. How well it is known is kept of the newest alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pipeline/motion_track.hpp"

namespace egofocus {

/// Thread: one. RT: yes.
class MotionHistory {
 public:
  /// At least so many entries are kept.
  static constexpr std::size_t kCapacity = 1024;
  /// Finer than this is not kept: with an IMU of any rate the history spans a second.
  static constexpr std::int64_t kSpacing_us = 1000;

  void clear() noexcept { size_ = 0; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  /// Precondition of both: not empty.
  [[nodiscard]] std::int64_t oldest_us() const noexcept { return entries_[0].t_us; }
  [[nodiscard]] std::int64_t newest_us() const noexcept { return newest_.t_us; }

  /// Times must not fall. The newest entry is replaced when it is closer than kSpacing_us to its predecessor.
  void add(const CameraMotion& motion) noexcept;

  /// Interpolated; held beyond both ends. From newest_us() on with its covariances. Precondition: not empty.
  [[nodiscard]] CameraMotion at(std::int64_t t_us) const noexcept;

  /// The entries that the motion between two times rests on, its neighbours on both sides included.
  [[nodiscard]] std::span<const MotionSample> between(std::int64_t begin_us,
                                                      std::int64_t end_us) const noexcept;

 private:
  /// Index of the last entry with t <= t_us, or 0.
  [[nodiscard]] std::size_t find(std::int64_t t_us) const noexcept;

  // Twice the room: the newer half moves to the front when the end is reached, so that entries stay in one
  // piece.
  MotionSample entries_[2 * kCapacity];
  std::size_t size_ = 0;
  CameraMotion newest_;
};

}  // namespace egofocus
