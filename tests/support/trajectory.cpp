#include "support/trajectory.hpp"

namespace egofocus::sim {

Trajectory::Trajectory(const CameraPose& start, std::vector<Phase> phases) : phases_(std::move(phases)) {
  for (const Phase& phase : phases_) duration_us_ += phase.duration_us;
  CameraPose pose = start;
  poses_.push_back(pose);
  constexpr double kStep = static_cast<double>(kStepUs) * 1e-6;
  for (std::int64_t t = 0; t < duration_us_; t += kStepUs) {
    const Twist twist = twist_at(t + kStepUs / 2);
    // The velocity acts in the frame half-way through the step.
    const Mat3 half = rotation(0.5 * kStep * twist.rate_rad_s);
    pose.position = pose.position + kStep * (pose.rotation * (half * twist.velocity_m_s));
    pose.rotation = pose.rotation * (half * half);
    poses_.push_back(pose);
  }
}

Twist Trajectory::twist_at(std::int64_t t_us) const {
  std::int64_t begin = 0;
  std::size_t i = 0;
  while (i + 1 < phases_.size() && t_us >= begin + phases_[i].duration_us) begin += phases_[i++].duration_us;
  const Twist& now = phases_[i].twist;
  const Twist before = i > 0 ? phases_[i - 1].twist : now;
  const std::int64_t into = t_us - begin;
  if (into >= kRampUs) return now;
  const double part = static_cast<double>(into) / static_cast<double>(kRampUs);
  const double weight = part * part * (3.0 - 2.0 * part);
  return {before.velocity_m_s + weight * (now.velocity_m_s - before.velocity_m_s),
          before.rate_rad_s + weight * (now.rate_rad_s - before.rate_rad_s)};
}

const CameraPose& Trajectory::pose_at(std::int64_t t_us) const {
  return poses_[static_cast<std::size_t>(t_us / kStepUs)];
}

}  // namespace egofocus::sim
