#include "pipeline/ego_motion.hpp"

#include "core/check.hpp"
#include "core/elementary.hpp"

namespace egofocus {
namespace {

constexpr std::int64_t kEndOfTime_us = std::int64_t{1} << 60;  // differences of times never overflow

bool finite(double x) noexcept {
  return x - x == 0;
}
bool positive(double x) noexcept {
  return finite(x) && x > 0;
}
bool plausible_time(std::int64_t t_us) noexcept {
  return t_us > -kEndOfTime_us && t_us < kEndOfTime_us;
}

/// No longer than `limit`; false for what is not finite.
bool within(const double (&v)[3], double limit) noexcept {
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2] <= limit * limit;
}

bool plausible(const ImuSample& sample, const MotionConfig& config) noexcept {
  constexpr double kMaxAccel_m_s2 = 500;
  return (sample.has_gyro || sample.has_accel) &&
         (!sample.has_gyro || within(sample.gyro_rad_s, config.max_rate_rad_s)) &&
         (!sample.has_accel || within(sample.accel_m_s2, kMaxAccel_m_s2));
}

bool plausible(const OdometrySample& sample, const MotionConfig& config) noexcept {
  const double* const c = sample.covariance_m2_s2;
  for (int i = 0; i < 6; ++i) {
    if (!finite(c[i])) return false;
  }
  if (sample.kind == OdometrySample::Kind::kWheelSpeed) {
    return absolute(sample.velocity_m_s[0]) <= config.max_speed_m_s && c[0] >= 0;
  }
  if (!within(sample.velocity_m_s, config.max_speed_m_s)) return false;
  bool stated = false;
  for (int i = 0; i < 6; ++i) stated = stated || c[i] != 0;
  // Positive definite, by its leading minors.
  const double minor2 = c[0] * c[3] - c[1] * c[1];
  const double minor3 = c[0] * (c[3] * c[5] - c[4] * c[4]) - c[1] * (c[1] * c[5] - c[4] * c[2]) +
                        c[2] * (c[1] * c[4] - c[3] * c[2]);
  return !stated || (c[0] > 0 && minor2 > 0 && minor3 > 0);
}

bool plausible(const PoseSample& sample) noexcept {
  constexpr double kMaxDistance_m = 1e8;
  const double* const q = sample.orientation_xyzw;
  const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return within(sample.position_m, kMaxDistance_m) && norm2 > 0.9 && norm2 < 1.1;
}

bool orthonormal(const double (&r)[9]) noexcept {
  constexpr double kTolerance = 1e-6;
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b) {
      const double dot = r[3 * a] * r[3 * b] + r[3 * a + 1] * r[3 * b + 1] + r[3 * a + 2] * r[3 * b + 2];
      if (!(absolute(dot - (a == b ? 1 : 0)) <= kTolerance)) return false;
    }
  }
  const double determinant = r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
                             r[2] * (r[3] * r[7] - r[4] * r[6]);
  return determinant > 0;
}

}  // namespace

Status EgoMotion::check(const MotionConfig& config) noexcept {
  const auto bad = [](const char* subject) { return Status(StatusCode::kBadMotion, subject); };
  if (!orthonormal(config.camera_from_body)) return bad("camera_from_body");
  constexpr double kMaxLeverArm_m = 100;
  if (!within(config.camera_in_body_m, kMaxLeverArm_m)) return bad("camera_in_body_m");
  if (!positive(config.gyro_noise_rad_s)) return bad("gyro_noise_rad_s");
  if (!positive(config.gyro_bias_walk_rad_s2)) return bad("gyro_bias_walk_rad_s2");
  if (!positive(config.accel_noise_m_s2)) return bad("accel_noise_m_s2");
  if (!positive(config.wheel_noise_m_s)) return bad("wheel_noise_m_s");
  if (!finite(config.wheel_scale_error) || config.wheel_scale_error < 0) return bad("wheel_scale_error");
  if (!positive(config.lateral_noise_m_s)) return bad("lateral_noise_m_s");
  if (!positive(config.max_speed_m_s)) return bad("max_speed_m_s");
  if (!positive(config.max_rate_rad_s)) return bad("max_rate_rad_s");
  if (config.stale_after_us <= 0) return bad("stale_after_us");
  if (config.max_pose_gap_us <= 0) return bad("max_pose_gap_us");
  return {};
}

EgoMotion::EgoMotion(const MotionConfig& config) noexcept
    : config_(config), of_(std::in_place_type<Odometric>, config) {
  EGOFOCUS_CHECK(check(config).ok());
  if (config.source == MotionSource::kPoses) of_.emplace<Posed>(config);
}

template <typename Sample>
void EgoMotion::wait(const Sample& sample, bool plausible, SortBuffer<Sample, kPending>& pending,
                     SampleCounters& counters) noexcept {
  if (!plausible || !plausible_time(sample.t_us)) {
    ++counters.invalid;
    return;
  }
  if (pending.full()) advance(pending.oldest().t_us);
  if (sample.t_us <= horizon_us_) {
    ++counters.late;
    return;
  }
  pending.insert(sample);
}

void EgoMotion::add(const ImuSample& sample) noexcept {
  ++imu_counters_.in;
  if (auto* const of = std::get_if<Odometric>(&of_))
    wait(sample, plausible(sample, config_), of->imu, imu_counters_);
}

void EgoMotion::add(const OdometrySample& sample) noexcept {
  ++odometry_counters_.in;
  if (auto* const of = std::get_if<Odometric>(&of_))
    wait(sample, plausible(sample, config_), of->odometry, odometry_counters_);
}

void EgoMotion::add(const PoseSample& sample) noexcept {
  ++pose_counters_.in;
  if (auto* const of = std::get_if<Posed>(&of_)) wait(sample, plausible(sample), of->poses, pose_counters_);
}

void EgoMotion::advance(std::int64_t t_us) noexcept {
  if (t_us <= horizon_us_) return;
  horizon_us_ = t_us;
  if (auto* const of = std::get_if<Posed>(&of_)) {
    while (of->poses.due(t_us)) use(*of, of->poses.take_oldest());
    return;
  }
  Odometric& of = *std::get_if<Odometric>(&of_);
  for (;;) {
    const bool imu = of.imu.due(t_us);
    const bool odometry = of.odometry.due(t_us);
    if (imu && (!odometry || of.imu.oldest().t_us <= of.odometry.oldest().t_us)) {
      use(of, of.imu.take_oldest());
    } else if (odometry) {
      use(of, of.odometry.take_oldest());
    } else {
      return;
    }
  }
}

void EgoMotion::use(Odometric& of, const ImuSample& sample) noexcept {
  ++imu_counters_.used;
  of.filter.use(sample);
  of.remember(sample.t_us, sample.has_gyro);
}

void EgoMotion::use(Odometric& of, const OdometrySample& sample) noexcept {
  ++odometry_counters_.used;
  if (!of.filter.use(sample)) ++odometry_counters_.rejected;
  of.remember(sample.t_us, false);
}

void EgoMotion::use(Posed& of, const PoseSample& sample) noexcept {
  ++pose_counters_.used;
  if (!of.history.add(sample)) ++pose_counters_.rejected;
}

/// The rate is known at the gyro's times: entries in between would hold it back. What odometry brought shows
/// up at the next gyro sample; only without a gyro at once.
void EgoMotion::Odometric::remember(std::int64_t t_us, bool new_rate) noexcept {
  if (!filter.ready()) {
    history.clear();
    return;
  }
  used_us = t_us;
  if (new_rate || !filter.has_gyro()) history.add(filter.camera_motion());
}

std::int64_t EgoMotion::earliest_us() const noexcept {
  if (const auto* const of = std::get_if<Posed>(&of_)) return of->history.earliest_us();
  const MotionHistory& history = std::get_if<Odometric>(&of_)->history;
  return history.empty() ? INT64_MAX : history.oldest_us();
}

std::int64_t EgoMotion::newest_us() const noexcept {
  if (const auto* const of = std::get_if<Posed>(&of_)) return of->history.newest_us();
  const Odometric& of = *std::get_if<Odometric>(&of_);
  return of.history.empty() ? INT64_MIN : of.used_us;
}

bool EgoMotion::is_stale(std::int64_t t_us) const noexcept {
  if (t_us - newest_us() > config_.stale_after_us) return true;
  const auto* const of = std::get_if<Odometric>(&of_);
  return of != nullptr && of->filter.doubts(t_us, config_.stale_after_us);
}

bool EgoMotion::known(std::int64_t begin_us, std::int64_t end_us) const noexcept {
  EGOFOCUS_CHECK(begin_us <= end_us);
  if (begin_us < earliest_us() || end_us - newest_us() > kMaxHold_us) return false;
  const auto* const of = std::get_if<Posed>(&of_);
  return of == nullptr || of->history.whole(begin_us, end_us);
}

bool EgoMotion::track(std::int64_t begin_us, std::int64_t end_us, MotionTrack& out) const noexcept {
  if (!known(begin_us, end_us)) return false;
  if (const auto* const of = std::get_if<Posed>(&of_)) {
    of->history.track(begin_us, end_us, out);
  } else {
    const MotionHistory& history = std::get_if<Odometric>(&of_)->history;
    integrate_track(history.between(begin_us, end_us), begin_us, end_us, out);
  }
  return true;
}

int EgoMotion::samples(std::int64_t begin_us, std::int64_t end_us,
                       std::span<MotionSample> out) const noexcept {
  if (out.empty() || !known(begin_us, end_us)) return 0;
  const int n = out.size() < kMaxSamples ? static_cast<int>(out.size()) : kMaxSamples;
  for (int i = 0; i < n; ++i) {
    const std::int64_t back_us = (end_us - begin_us) * (n - 1 - i) / (n > 1 ? n - 1 : 1);
    out[static_cast<std::size_t>(i)] = at_end(end_us - back_us);
  }
  return n;
}

CameraMotion EgoMotion::at_end(std::int64_t t_us) const noexcept {
  if (known(t_us, t_us)) {
    const auto* const of = std::get_if<Posed>(&of_);
    return of != nullptr ? of->history.at(t_us) : std::get_if<Odometric>(&of_)->history.at(t_us);
  }
  CameraMotion nothing;
  nothing.t_us = t_us;
  return nothing;
}

}  // namespace egofocus
