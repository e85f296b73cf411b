#include "pipeline/motion_history.hpp"

#include "core/check.hpp"

namespace egofocus {
namespace {

void mix(const double (&a)[3], const double (&b)[3], double share, double (&out)[3]) noexcept {
  for (int i = 0; i < 3; ++i) out[i] = a[i] + (b[i] - a[i]) * share;
}

}  // namespace

void MotionHistory::add(const CameraMotion& motion) noexcept {
  EGOFOCUS_CHECK(size_ == 0 || motion.t_us >= newest_us());
  newest_ = motion;
  const bool close = size_ >= 2 && motion.t_us - entries_[size_ - 2].t_us < kSpacing_us;
  const bool same = size_ >= 1 && motion.t_us == entries_[size_ - 1].t_us;
  if (close || same) {
    entries_[size_ - 1] = motion;
    return;
  }
  if (size_ == 2 * kCapacity) {
    for (std::size_t i = 0; i < kCapacity; ++i) entries_[i] = entries_[kCapacity + i];
    size_ = kCapacity;
  }
  entries_[size_++] = motion;
}

std::size_t MotionHistory::find(std::int64_t t_us) const noexcept {
  std::size_t low = 0;
  std::size_t high = size_;
  while (high - low > 1) {
    const std::size_t middle = low + (high - low) / 2;
    (entries_[middle].t_us <= t_us ? low : high) = middle;
  }
  return low;
}

CameraMotion MotionHistory::at(std::int64_t t_us) const noexcept {
  EGOFOCUS_CHECK(size_ > 0);
  CameraMotion motion;
  if (t_us >= newest_us()) {
    motion = newest_;
    motion.t_us = t_us;
    return motion;
  }
  const std::size_t i = find(t_us);
  const MotionSample& a = entries_[i];
  static_cast<MotionSample&>(motion) = a;
  motion.t_us = t_us;
  if (t_us <= a.t_us) return motion;
  const MotionSample& b = entries_[i + 1];
  const double share = static_cast<double>(t_us - a.t_us) / static_cast<double>(b.t_us - a.t_us);
  mix(a.velocity_m_s, b.velocity_m_s, share, motion.velocity_m_s);
  mix(a.angular_rate_rad_s, b.angular_rate_rad_s, share, motion.angular_rate_rad_s);
  return motion;
}

std::span<const MotionSample> MotionHistory::between(std::int64_t begin_us,
                                                     std::int64_t end_us) const noexcept {
  EGOFOCUS_CHECK(size_ > 0);
  const std::size_t first = find(begin_us);
  const std::size_t last = find(end_us);
  const std::size_t stop = last + 1 < size_ ? last + 2 : size_;
  return {entries_ + first, stop - first};
}

}  // namespace egofocus
