#include "hal/inivation_imu.hpp"

namespace egofocus {
namespace {

constexpr double kStandardGravity_m_s2 = 9.80665;
constexpr double kRadPerDegree = 3.14159265358979323846 / 180.0;
constexpr std::size_t kAccel = 0;
constexpr std::size_t kTemperature = 6;
constexpr std::size_t kGyro = 8;

}  // namespace

void InivationImu::begin() noexcept {
  is_open_ = true;
  next_ = present_from(0);
}

void InivationImu::configure(std::uint8_t data) noexcept {
  // A range code stands for 2 g and 250 deg/s doubled so often. BMI160 counts its gyro ranges downwards, from
  // 2000 deg/s, and has five, so its code is one bit wider.
  const bool is_bmi160 = format_ == InivationFormat::kDvxplorer;
  const int accel_range = is_bmi160 ? (data >> 3) & 3 : (data >> 2) & 3;
  const int gyro_range = is_bmi160 ? data & 7 : data & 3;
  accel_m_s2_per_unit_ = kStandardGravity_m_s2 * static_cast<double>(2 << accel_range) / 32768.0;
  const double full_scale_deg_s = is_bmi160 ? 2000.0 / static_cast<double>(1 << gyro_range)
                                            : 250.0 * static_cast<double>(1 << gyro_range);
  gyro_rad_s_per_unit_ = full_scale_deg_s * kRadPerDegree / 32768.0;
  has_temperature_ = (data & 0x20) != 0;
  has_gyro_ = (data & 0x40) != 0;
  has_accel_ = (data & 0x80) != 0;
  is_configured_ = true;
  next_ = present_from(0);
}

void InivationImu::add(std::uint8_t byte) noexcept {
  if (next_ >= kBytes) {
    next_ = kBytes + 1;
    return;
  }
  bytes_[next_] = byte;
  next_ = present_from(next_ + 1);
}

bool InivationImu::end(std::int64_t t_us, ImuSample& sample, InivationCounters& counters) noexcept {
  // What began before this stream was listened to is no loss.
  if (!is_open_) return false;
  is_open_ = false;
  if (!is_configured_ || next_ != kBytes || !(has_accel_ || has_gyro_)) {
    counters.count(InivationViolation::kImuIncomplete);
    return false;
  }
  sample = {.t_us = t_us, .has_gyro = has_gyro_, .has_accel = has_accel_};
  for (int axis = 0; axis < 3; ++axis) {
    if (has_accel_) sample.accel_m_s2[axis] = value(kAccel, axis) * accel_m_s2_per_unit_;
    if (has_gyro_) sample.gyro_rad_s[axis] = value(kGyro, axis) * gyro_rad_s_per_unit_;
  }
  ++counters.imu_samples;
  return true;
}

bool InivationImu::has_part_at(std::size_t byte) const noexcept {
  return byte < kTemperature ? has_accel_ : byte < kGyro ? has_temperature_ : has_gyro_;
}

std::size_t InivationImu::present_from(std::size_t byte) const noexcept {
  while (byte < kBytes && !has_part_at(byte)) ++byte;
  return byte;
}

// The chip of the DVXplorer is turned: its first word is y, its second x.
double InivationImu::value(std::size_t first, int axis) const noexcept {
  const int word = format_ == InivationFormat::kDvxplorer && axis < 2 ? 1 - axis : axis;
  const std::size_t at = first + 2 * static_cast<std::size_t>(word);
  const auto raw = static_cast<std::int16_t>(bytes_[at] << 8 | bytes_[at + 1]);
  return (flips_ >> (2 - axis) & 1) != 0 ? -static_cast<double>(raw) : static_cast<double>(raw);
}

}  // namespace egofocus
