#include "pipeline/pose_history.hpp"

#include "core/check.hpp"
#include "core/elementary.hpp"

namespace egofocus {
namespace {

double seconds(std::int64_t us) noexcept {
  return static_cast<double>(us) * 1e-6;
}

}  // namespace

PoseHistory::PoseHistory(const MotionConfig& config) noexcept
    : max_gap_us_(config.max_pose_gap_us),
      max_speed_m_s_(config.max_speed_m_s),
      max_rate_rad_s_(config.max_rate_rad_s) {}

bool PoseHistory::add(const PoseSample& sample) noexcept {
  const double* const q = sample.orientation_xyzw;
  Pose next;
  next.t_us = sample.t_us;
  next.position_m = Vec3(sample.position_m[0], sample.position_m[1], sample.position_m[2]);
  next.orientation = normalized({q[0], q[1], q[2], q[3]});
  bool plausible = true;
  if (size_ > 0) {
    const Pose& last = pose(size_ - 1);
    if (next.t_us <= last.t_us) return false;
    const double dt_s = seconds(next.t_us - last.t_us);
    next.velocity_m_s = (next.position_m - last.position_m) / dt_s;
    next.rate_rad_s = to_rotation_vector(conjugate(last.orientation) * next.orientation) / dt_s;
    plausible = next.velocity_m_s.squaredNorm() <= max_speed_m_s_ * max_speed_m_s_ &&
                next.rate_rad_s.squaredNorm() <= max_rate_rad_s_ * max_rate_rad_s_;
    next.joined = plausible && next.t_us - last.t_us <= max_gap_us_;
  }
  if (size_ == kCapacity) {
    first_ = (first_ + 1) & (kCapacity - 1);
    --size_;
  }
  poses_[(first_ + size_) & (kCapacity - 1)] = next;
  ++size_;
  return plausible;
}

std::int64_t PoseHistory::earliest_us() const noexcept {
  return size_ < 2 ? INT64_MAX : pose(0).t_us;
}

std::int64_t PoseHistory::newest_us() const noexcept {
  return size_ < 2 ? INT64_MIN : pose(size_ - 1).t_us;
}

std::uint32_t PoseHistory::step_of(std::int64_t t_us) const noexcept {
  std::uint32_t low = 1;  // the last step whose earlier pose is not after t_us
  std::uint32_t high = size_;
  while (high - low > 1) {
    const std::uint32_t middle = low + (high - low) / 2;
    (pose(middle - 1).t_us <= t_us ? low : high) = middle;
  }
  return low;
}

bool PoseHistory::whole(std::int64_t begin_us, std::int64_t end_us) const noexcept {
  std::uint32_t step = step_of(begin_us);
  bool joined = pose(step).joined;
  for (++step; step < size_ && pose(step - 1).t_us < end_us; ++step) joined = joined && pose(step).joined;
  return joined;
}

PoseHistory::Placed PoseHistory::place(std::uint32_t step, double t_s) const noexcept {
  const Pose& from = pose(step - 1);
  const Pose& to = pose(step);
  return {from.position_m + to.velocity_m_s * t_s,
          from.orientation * from_rotation_vector(to.rate_rad_s * t_s)};
}

CameraMotion PoseHistory::at(std::int64_t t_us) const noexcept {
  EGOFOCUS_CHECK(size_ >= 2);
  const std::uint32_t step = step_of(t_us);
  const Placed now = place(step, seconds(t_us - pose(step - 1).t_us));
  const Vec3 velocity = to_matrix(now.orientation).transpose() * pose(step).velocity_m_s;
  CameraMotion motion;
  motion.t_us = t_us;
  for (int i = 0; i < 3; ++i) {
    motion.velocity_m_s[i] = velocity[i];
    motion.angular_rate_rad_s[i] = pose(step).rate_rad_s[i];
  }
  return motion;
}

void PoseHistory::track(std::int64_t begin_us, std::int64_t end_us, MotionTrack& out) const noexcept {
  EGOFOCUS_CHECK(size_ >= 2 && begin_us <= end_us);
  out.begin_us = begin_us;
  out.end_us = end_us;
  const std::uint32_t last = step_of(end_us);
  const Placed end = place(last, seconds(end_us - pose(last - 1).t_us));
  const Quaternion to_end = conjugate(end.orientation);
  const Mat3 turn_to_end = to_matrix(to_end);
  const double spacing_us = static_cast<double>(end_us - begin_us) / (MotionTrack::kKnots - 1);
  std::uint32_t step = step_of(begin_us);
  for (int i = 0; i < MotionTrack::kKnots - 1; ++i) {
    const double offset_us = i * spacing_us;  // after begin_us: small numbers keep their digits
    while (step < last && static_cast<double>(pose(step).t_us - begin_us) <= offset_us) ++step;
    const double t_s = (offset_us - static_cast<double>(pose(step - 1).t_us - begin_us)) * 1e-6;
    const Placed now = place(step, t_s);
    store(to_matrix(to_end * now.orientation), turn_to_end * (now.position_m - end.position_m), out.knots[i]);
  }
  store(Mat3::Identity(), Vec3::Zero(), out.knots[MotionTrack::kKnots - 1]);
}

}  // namespace egofocus
