#include "pipeline/motion_track.hpp"

#include "core/check.hpp"
#include "core/elementary.hpp"
#include "pipeline/rotation.hpp"

namespace egofocus {
namespace {

Vec3 vec3(const double* v) noexcept {
  return {v[0], v[1], v[2]};
}

/// (T, omega) at one time.
struct Twist {
  Vec3 velocity;
  Vec3 rate;
};

Twist mean(const Twist& a, const Twist& b) noexcept {
  return {(a.velocity + b.velocity) * 0.5, (a.rate + b.rate) * 0.5};
}

/// Where the camera is, seen from where it was at the window's begin.
struct Pose {
  Quaternion orientation;
  Vec3 position = Vec3::Zero();
};

/// The turn during h seconds while the rate goes linearly from a to b: Magnus expansion of Q' = Q [omega],
/// 4th order.
Quaternion turn(const Vec3& a, const Vec3& b, double h) noexcept {
  return from_rotation_vector((a + b) * (h / 2) + cross(a, b) * (h * h / 12));
}

/// One step of linear (T, omega). The path p' = Q T by Simpson's rule.
void advance(Pose& pose, const Twist& from, const Twist& to, double h) noexcept {
  const Twist middle = mean(from, to);
  const Quaternion half = pose.orientation * turn(from.rate, middle.rate, h / 2);
  const Quaternion whole = normalized(pose.orientation * turn(from.rate, to.rate, h));
  pose.position += (to_matrix(pose.orientation) * from.velocity + to_matrix(half) * middle.velocity * 4.0 +
                    to_matrix(whole) * to.velocity) *
                   (h / 6);
  pose.orientation = whole;
}

/// Piecewise linear through samples; asked at times that only rise. Times are microseconds after the window's
/// begin.
class Twists {
 public:
  Twists(std::span<const MotionSample> samples, std::int64_t begin_us) noexcept
      : samples_(samples), begin_us_(begin_us) {}

  /// Time of the first sample after t, or `limit` where that is sooner.
  double next_bend(double t, double limit) noexcept {
    while (next_ < samples_.size() && time(next_) <= t) ++next_;
    return next_ < samples_.size() && time(next_) < limit ? time(next_) : limit;
  }

  /// At t, which lies in the piece that ends at the sample after the last next_bend().
  [[nodiscard]] Twist at(double t) const noexcept {
    if (next_ == 0) return sample(0);
    if (next_ == samples_.size()) return sample(next_ - 1);
    const Twist a = sample(next_ - 1);
    const Twist b = sample(next_);
    const double share = (t - time(next_ - 1)) / (time(next_) - time(next_ - 1));
    return {a.velocity + (b.velocity - a.velocity) * share, a.rate + (b.rate - a.rate) * share};
  }

 private:
  [[nodiscard]] double time(std::size_t i) const noexcept {
    return static_cast<double>(samples_[i].t_us - begin_us_);
  }
  [[nodiscard]] Twist sample(std::size_t i) const noexcept {
    return {vec3(samples_[i].velocity_m_s), vec3(samples_[i].angular_rate_rad_s)};
  }

  std::span<const MotionSample> samples_;
  std::int64_t begin_us_;
  std::size_t next_ = 0;
};

}  // namespace

void store(const Mat3& rotation, const Vec3& centre, MotionKnot& knot) noexcept {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) knot.rotation[3 * row + column] = rotation(row, column);
    knot.centre_m[row] = centre[row];
  }
}

void integrate_track(std::span<const MotionSample> motion, std::int64_t begin_us, std::int64_t end_us,
                     MotionTrack& out) noexcept {
  EGOFOCUS_CHECK(!motion.empty() && begin_us <= end_us);
  out.begin_us = begin_us;
  out.end_us = end_us;

  Pose poses[MotionTrack::kKnots];
  Twists twists(motion, begin_us);
  const double spacing_us = static_cast<double>(end_us - begin_us) / (MotionTrack::kKnots - 1);
  double t = 0;
  for (int i = 1; i < MotionTrack::kKnots; ++i) {
    poses[i] = poses[i - 1];
    const double knot = i * spacing_us;
    while (t < knot) {
      const double until = twists.next_bend(t, knot);
      advance(poses[i], twists.at(t), twists.at(until), (until - t) * 1e-6);
      t = until;
    }
  }

  const Pose& end = poses[MotionTrack::kKnots - 1];
  const Quaternion to_end = conjugate(end.orientation);
  const Mat3 turn_to_end = to_matrix(to_end);
  for (int i = 0; i < MotionTrack::kKnots - 1; ++i) {
    store(to_matrix(to_end * poses[i].orientation), turn_to_end * (poses[i].position - end.position),
          out.knots[i]);
  }
  store(Mat3::Identity(), Vec3::Zero(), out.knots[MotionTrack::kKnots - 1]);
}

double speed_sigma_m_s(const CameraMotion& motion) noexcept {
  const double* const c = motion.velocity_covariance_m2_s2;
  const double* const v = motion.velocity_m_s;
  const double speed2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  if (speed2 < 1e-12) {
    const double most = c[0] > c[3] ? c[0] : c[3];
    return square_root(most > c[5] ? most : c[5]);
  }
  const double along = v[0] * (c[0] * v[0] + 2 * c[1] * v[1] + 2 * c[2] * v[2]) +
                       v[1] * (c[3] * v[1] + 2 * c[4] * v[2]) + v[2] * c[5] * v[2];
  return square_root((along > 0 ? along : 0) / speed2);
}

}  // namespace egofocus
