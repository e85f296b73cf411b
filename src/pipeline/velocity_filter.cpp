#include "pipeline/velocity_filter.hpp"

#include "core/elementary.hpp"
#include "pipeline/rotation.hpp"

namespace egofocus {
namespace {

constexpr double kGravity_m_s2 = 9.80665;

// What is believed before anything was measured (1-sigma).
constexpr double kGyroBiasPrior_rad_s = 0.03;
constexpr double kAccelBiasPrior_m_s2 = 0.1;
constexpr double kGravityPrior_m_s2 = 1.5;         // the first reading may come from a robot that accelerates
constexpr double kGravityLengthPrior_m_s2 = 0.03;  // places on earth
constexpr double kVelocityPrior_m_s = 10;

// How far things wander, per sqrt(s).
constexpr double kGravityWalk_m_s2 = 0.002;  // sculling and what else a sampled gyro does not see
constexpr double kAccelBiasWalk_m_s2 = 0.002;
constexpr double kScaleWalk = 1e-4;
// What stands in for a missing sensor: that much, changing every kUnknownFor_s.
constexpr double kUnknownAccel_m_s2 = 3;
constexpr double kUnknownRate_rad_s = 0.5;
constexpr double kUnknownFor_s = 0.2;
// Wheels that give no pulses may turn at up to 1..2 km/h: a reading of exactly zero says no more than that.
// Neighbouring ones are wrong by the same, so that each alone counts for less.
constexpr double kSilentWheel_m_s = 0.25;
constexpr double kSilentWheelsAlike = 16;
constexpr double kDeparture_m_s = 0.1;  // what a robot may gain before it is seen to move

constexpr double kGate2 = 25;  // squared: 5 sigma
constexpr std::int64_t kLateralEvery_us = 20000;

double seconds(std::int64_t us) noexcept {
  return static_cast<double>(us) * 1e-6;
}
Vec3 vec3(const double (&v)[3]) noexcept {
  return {v[0], v[1], v[2]};
}

void store_upper(const Mat3& m, double (&out)[6]) noexcept {
  out[0] = m(0, 0);
  out[1] = m(0, 1);
  out[2] = m(0, 2);
  out[3] = m(1, 1);
  out[4] = m(1, 2);
  out[5] = m(2, 2);
}

}  // namespace

VelocityFilter::VelocityFilter(const MotionConfig& config) noexcept : config_(config), standstill_(config) {
  const double* const r = config.camera_from_body;
  camera_from_body_ << r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8];
  lever_arm_ = vec3(config.camera_in_body_m);
  for (int i = 0; i < 3; ++i)
    covariance_(kGyroBias + i, kGyroBias + i) = kGyroBiasPrior_rad_s * kGyroBiasPrior_rad_s;
  for (int i = 0; i < 3; ++i) {
    covariance_(kAccelBias + i, kAccelBias + i) = kAccelBiasPrior_m_s2 * kAccelBiasPrior_m_s2;
  }
  covariance_(kScale, kScale) = config.wheel_scale_error * config.wheel_scale_error;
}

/// Takes a new reading; returns the mean of it and the last one, which stands for the time in between.
Vec3 VelocityFilter::renew(Reading& reading, const double (&value)[3], std::int64_t t_us) noexcept {
  const Vec3 last = reading.value;
  const std::int64_t age_us = t_us - reading.t_us;
  reading.value = vec3(value);
  reading.t_us = t_us;
  if (age_us > kHold_us) return reading.value;
  reading.period_s = seconds(age_us);
  return (last + reading.value) * 0.5;
}

void VelocityFilter::use(const ImuSample& sample) noexcept {
  const Vec3 gyro = sample.has_gyro ? renew(gyro_, sample.gyro_rad_s, sample.t_us) : gyro_.value;
  const Vec3 accel = sample.has_accel ? renew(accel_, sample.accel_m_s2, sample.t_us) : accel_.value;
  move_to(sample.t_us, gyro, accel);
  if (sample.has_gyro) standstill_.see_gyro(gyro_.value, sample.t_us);
  if (sample.has_accel) standstill_.see_accel(accel_.value, sample.t_us);
  notice_departure();
  if (sample.has_accel && !gravity_known_) start_gravity();

  if (standstill_.standing()) {
    if (!sample.has_gyro) return;
    for (int i = 0; i < 3; ++i)
      correct(kGyroBias + i, gyro_.value[i], config_.gyro_noise_rad_s, Outlier::kReject);
  } else if (config_.model == MotionModel::kWheeled && ready_ && t_us_ - lateral_us_ >= kLateralEvery_us) {
    lateral_us_ = t_us_;
    for (int i = 1; i < 3; ++i) correct(kVelocity + i, 0, config_.lateral_noise_m_s, Outlier::kWeaken);
  }
}

bool VelocityFilter::use(const OdometrySample& sample) noexcept {
  move_to(sample.t_us, gyro_.value, accel_.value);
  const bool wheel = sample.kind == OdometrySample::Kind::kWheelSpeed;
  const Vec3 speed = wheel ? Vec3(sample.velocity_m_s[0], 0, 0) : vec3(sample.velocity_m_s);
  standstill_.see_odometry(speed, sample.t_us);
  notice_departure();
  if (!ready_ || odometry_us_ - accepted_us_ > kLost_us) {
    if (ready_) {
      doubt_until_us_ = t_us_ + kDoubt_us;
      forget_odometry();
    }
    start_velocity(sample);
  }
  const std::int64_t since_us = t_us_ - odometry_us_;
  odometry_us_ = t_us_;
  innovation_[0] = innovation_[1] = innovation_[2] = 0;
  bool is_accepted = true;
  if (standstill_.standing()) {
    measure_standstill();
  } else {
    is_accepted = wheel ? measure_wheel(sample) : measure_body(sample);
  }
  notice_strain(since_us);
  if (is_accepted) accepted_us_ = t_us_;
  return is_accepted;
}

// What was learnt while it contradicted the rest is as wrong as it may be.
void VelocityFilter::forget_odometry() noexcept {
  scale_ = 0;
  accel_bias_ = Vec3::Zero();
  gravity_known_ = false;
  const auto forget = [this](int state, double sigma) {
    covariance_.row(state).setZero();
    covariance_.col(state).setZero();
    covariance_(state, state) = sigma * sigma;
  };
  forget(kScale, config_.wheel_scale_error);
  for (int i = 0; i < 3; ++i) forget(kAccelBias + i, kAccelBiasPrior_m_s2);
}

void VelocityFilter::notice_strain(std::int64_t since_us) noexcept {
  const double share = seconds(since_us) < kStrainFor_s ? seconds(since_us) / kStrainFor_s : 1;
  for (int i = 0; i < 3; ++i) {
    strain_[i] += share * (innovation_[i] - strain_[i]);
    if (absolute(strain_[i]) > kMostStrain) doubt_until_us_ = t_us_ + kDoubt_us;
  }
}

bool VelocityFilter::doubts(std::int64_t t_us, std::int64_t limit_us) const noexcept {
  const bool had_gyro = gyro_.t_us > INT64_MIN / 4;
  const bool rejects = odometry_us_ > accepted_us_;
  return (had_gyro && t_us - gyro_.t_us > limit_us) || (rejects && t_us - accepted_us_ > limit_us) ||
         t_us < doubt_until_us_;
}

/// Propagation, exact in the rotation and of second order in the rest: the step's mean readings act in its
/// middle.
void VelocityFilter::move_to(std::int64_t t_us, const Vec3& gyro, const Vec3& accel) noexcept {
  const std::int64_t step_us = t_us - t_us_;
  t_us_ = t_us;
  if (step_us > kRestart_us) {
    ready_ = false;
    gravity_known_ = false;
    return;
  }
  if (t_us - odometry_us_ > kSilence_us) ready_ = false;
  if (step_us == 0) return;

  const double h = seconds(step_us);
  const bool turning = has_gyro();
  const bool pushed = has_accel() && gravity_known_;
  const Vec3 rate = turning ? Vec3(gyro - gyro_bias_) : Vec3(Vec3::Zero());
  const Mat3 half_turn = to_matrix(from_rotation_vector(rate * (-h / 2)));
  const Mat3 turn = half_turn * half_turn;
  if (pushed) velocity_ = turn * velocity_ + half_turn * (accel - accel_bias_ - half_turn * gravity_) * h;
  gravity_ = turn * gravity_;

  // A rate error d turns v and g by h v x d and h g x d; a bias error is a rate error with the other sign.
  const Mat3 velocity_turn = skew(velocity_);
  const Mat3 gravity_turn = skew(gravity_);
  Covariance f = Covariance::Identity();
  f.block<3, 3>(kGravity, kGravity) = turn;
  f.block<3, 3>(kGravity, kGyroBias) = gravity_turn * -h;
  if (pushed) {
    f.block<3, 3>(kVelocity, kVelocity) = turn;
    f.block<3, 3>(kVelocity, kGravity) = turn * -h;
    f.block<3, 3>(kVelocity, kGyroBias) = velocity_turn * -h;
    f.block<3, 3>(kVelocity, kAccelBias) = half_turn * -h;
  }
  covariance_ = product(product(f, covariance_), f.transpose());

  const double gyro_sigma = turning ? config_.gyro_noise_rad_s : kUnknownRate_rad_s;
  const double turn_noise = gyro_sigma * gyro_sigma * (turning ? gyro_.period_s : kUnknownFor_s) * h;
  covariance_.block<3, 3>(kGravity, kGravity) += gravity_turn * gravity_turn.transpose() * turn_noise;
  if (pushed) {
    const Mat3 both = velocity_turn * gravity_turn.transpose() * turn_noise;
    covariance_.block<3, 3>(kVelocity, kVelocity) += velocity_turn * velocity_turn.transpose() * turn_noise;
    covariance_.block<3, 3>(kVelocity, kGravity) += both;
    covariance_.block<3, 3>(kGravity, kVelocity) += both.transpose();
  }
  const double accel_sigma = pushed ? config_.accel_noise_m_s2 : kUnknownAccel_m_s2;
  const double push_noise = accel_sigma * accel_sigma * (pushed ? accel_.period_s : kUnknownFor_s) * h;
  for (int i = 0; i < 3; ++i) {
    covariance_(kVelocity + i, kVelocity + i) += push_noise;
    covariance_(kGravity + i, kGravity + i) += kGravityWalk_m_s2 * kGravityWalk_m_s2 * h;
    covariance_(kGyroBias + i, kGyroBias + i) +=
        config_.gyro_bias_walk_rad_s2 * config_.gyro_bias_walk_rad_s2 * h;
    covariance_(kAccelBias + i, kAccelBias + i) += kAccelBiasWalk_m_s2 * kAccelBiasWalk_m_s2 * h;
  }
  covariance_(kScale, kScale) += kScaleWalk * kScaleWalk * h;
  make_symmetric(covariance_);
}

void VelocityFilter::start_gravity() noexcept {
  gravity_known_ = true;
  gravity_ = accel_.value - accel_bias_;
  covariance_.middleRows<3>(kGravity).setZero();
  covariance_.middleCols<3>(kGravity).setZero();
  for (int i = 0; i < 3; ++i)
    covariance_(kGravity + i, kGravity + i) = kGravityPrior_m_s2 * kGravityPrior_m_s2;
  const double length = square_root(gravity_.squaredNorm());
  if (length < kGravity_m_s2 / 2) return;  // its direction says nothing
  Row h = Row::Zero();
  h.segment<3>(kGravity) = gravity_.transpose() / length;
  update(h, kGravity_m_s2 - length, kGravityLengthPrior_m_s2 * kGravityLengthPrior_m_s2);
}

void VelocityFilter::start_velocity(const OdometrySample& sample) noexcept {
  ready_ = true;
  const bool wheel = sample.kind == OdometrySample::Kind::kWheelSpeed;
  velocity_ = wheel ? Vec3(sample.velocity_m_s[0] / (1 + scale_), 0, 0) : vec3(sample.velocity_m_s);
  covariance_.middleRows<3>(kVelocity).setZero();
  covariance_.middleCols<3>(kVelocity).setZero();
  for (int i = 0; i < 3; ++i)
    covariance_(kVelocity + i, kVelocity + i) = kVelocityPrior_m_s * kVelocityPrior_m_s;
  if (config_.model != MotionModel::kWheeled) return;
  for (int i = 1; i < 3; ++i) correct(kVelocity + i, 0, config_.lateral_noise_m_s, Outlier::kWeaken);
}

bool VelocityFilter::measure_wheel(const OdometrySample& sample) noexcept {
  const double stated = sample.covariance_m2_s2[0];
  const bool silent = sample.velocity_m_s[0] == 0 && config_.wheel_noise_m_s < kSilentWheel_m_s;
  const double sigma = silent ? kSilentWheel_m_s : config_.wheel_noise_m_s;
  const double variance = stated > 0 ? stated : sigma * sigma;
  const double share = silent && !(stated > 0) ? kSilentWheelsAlike : 1;
  Row h = Row::Zero();
  h(kVelocity) = 1 + scale_;
  h(kScale) = velocity_[0];
  const double residual = sample.velocity_m_s[0] - (1 + scale_) * velocity_[0];
  if (!fits(0, h, residual, variance)) return false;
  update(h, residual, share * variance);
  return true;
}

/// Three correlated components become three independent ones of variance 1: with C = L L^T, the rows of L^-1.
bool VelocityFilter::measure_body(const OdometrySample& sample) noexcept {
  const double* c = sample.covariance_m2_s2;
  const double sigma = config_.wheel_noise_m_s;
  const double unstated[6] = {sigma * sigma, 0, 0, sigma * sigma, 0, sigma * sigma};
  if (!(c[0] > 0)) c = unstated;
  const double l00 = square_root(c[0]);
  const double l10 = c[1] / l00;
  const double l20 = c[2] / l00;
  const double l11 = square_root(c[3] - l10 * l10);
  const double l21 = (c[4] - l20 * l10) / l11;
  const double l22 = square_root(c[5] - l20 * l20 - l21 * l21);
  const Vec3 row0(1 / l00, 0, 0);
  const Vec3 row1(-l10 * row0[0] / l11, 1 / l11, 0);
  const Vec3 row2((-l20 * row0[0] - l21 * row1[0]) / l22, -l21 * row1[1] / l22, 1 / l22);

  const Vec3 measured = vec3(sample.velocity_m_s);
  const Vec3* const rows[3] = {&row0, &row1, &row2};
  for (int pass = 0; pass < 2;
       ++pass) {  // first all gates, then all updates: a sample counts whole or not at all
    for (int i = 0; i < 3; ++i) {
      const Vec3* const row = rows[i];
      Row h = Row::Zero();
      h.segment<3>(kVelocity) = row->transpose();
      const double residual = row->dot(measured - velocity_);
      if (pass == 0 && !fits(i, h, residual, 1)) return false;
      if (pass == 1) update(h, residual, 1);
    }
  }
  return true;
}

/// Standstill is given up late: until then the velocity was held at zero, however it grew.
void VelocityFilter::notice_departure() noexcept {
  const bool stood = stood_;
  stood_ = standstill_.standing();
  if (!stood || stood_) return;
  for (int i = 0; i < 3; ++i) covariance_(kVelocity + i, kVelocity + i) += kDeparture_m_s * kDeparture_m_s;
}

void VelocityFilter::measure_standstill() noexcept {
  // Half a step of quantisation may hide in an odometry that reads zero.
  for (int i = 0; i < 3; ++i) correct(kVelocity + i, 0, config_.wheel_noise_m_s / 2, Outlier::kWeaken);
}

bool VelocityFilter::fits(int component, const Row& h, double residual, double variance) noexcept {
  const double expected = dot(product(h, covariance_), h) + variance;
  innovation_[component] = residual / square_root(expected);
  return residual * residual <= kGate2 * expected;
}

void VelocityFilter::update(const Row& h, double residual, double variance) noexcept {
  const Row ph = product(h, covariance_);
  const double expected = dot(ph, h) + variance;
  const Row gain = ph / expected;
  velocity_ += gain.segment<3>(kVelocity).transpose() * residual;
  gravity_ += gain.segment<3>(kGravity).transpose() * residual;
  gyro_bias_ += gain.segment<3>(kGyroBias).transpose() * residual;
  accel_bias_ += gain.segment<3>(kAccelBias).transpose() * residual;
  scale_ += gain(kScale) * residual;
  subtract_outer(covariance_, gain, ph);
}

/// One state is measured directly. Beyond the gate it is ignored, or so weakened that it sits on the gate:
/// what is wrong for long then still wins in the end.
void VelocityFilter::correct(int state, double value, double sigma, Outlier outlier) noexcept {
  const double now = state < kGravity ? velocity_[state - kVelocity] : gyro_bias_[state - kGyroBias];
  const double residual = value - now;
  double variance = sigma * sigma;
  const double expected = covariance_(state, state) + variance;
  if (residual * residual > kGate2 * expected) {
    if (outlier == Outlier::kReject) return;
    variance = residual * residual / kGate2 - covariance_(state, state);
  }
  Row h = Row::Zero();
  h(state) = 1;
  update(h, residual, variance);
}

CameraMotion VelocityFilter::camera_motion() const noexcept {
  const bool turning = has_gyro();
  const Vec3 rate = turning ? Vec3(gyro_.value - gyro_bias_) : Vec3(Vec3::Zero());
  const Vec3 velocity = velocity_ + cross(rate, lever_arm_);

  // v + (gyro - b) x l depends on b by l x db, and on the gyro's noise by the opposite.
  const Mat3 lever = skew(lever_arm_);
  const double sigma = turning ? config_.gyro_noise_rad_s : kUnknownRate_rad_s;
  const Mat3 cross_term = covariance_.block<3, 3>(kVelocity, kGyroBias) * lever.transpose();
  Mat3 rate_covariance = Mat3::Identity() * (sigma * sigma);
  if (turning) rate_covariance += covariance_.block<3, 3>(kGyroBias, kGyroBias);
  Mat3 velocity_covariance = covariance_.block<3, 3>(kVelocity, kVelocity);
  velocity_covariance += lever * rate_covariance * lever.transpose();
  if (turning) velocity_covariance += cross_term + cross_term.transpose();

  const Vec3 velocity_out = camera_from_body_ * velocity;
  const Vec3 rate_out = camera_from_body_ * rate;
  CameraMotion motion;
  motion.t_us = t_us_;
  for (int i = 0; i < 3; ++i) {
    motion.velocity_m_s[i] = velocity_out[i];
    motion.angular_rate_rad_s[i] = rate_out[i];
  }
  store_upper(camera_from_body_ * velocity_covariance * camera_from_body_.transpose(),
              motion.velocity_covariance_m2_s2);
  store_upper(camera_from_body_ * rate_covariance * camera_from_body_.transpose(),
              motion.rate_covariance_rad2_s2);
  return motion;
}

}  // namespace egofocus
