// The inertial sensor of iniVation's cameras: bytes between two marks -> one sample.
#pragma once

#include <cstddef>
#include <cstdint>

#include "egofocus/types.hpp"
#include "hal/inivation_words.hpp"

namespace egofocus {

/// Collects the big-endian bytes of one sample: accelerometer, temperature, gyro, of which the configuration
/// word says which are there. Values are in SI and in the sensor's axes as the camera's logic names them,
/// with `flips` applied. Source: libcaer, src/davis.c and src/dvxplorer.c (IMU events); scales: MPU-6050
/// register map, ACCEL_CONFIG and GYRO_CONFIG; BMI160 data sheet, ACC_RANGE and GYR_RANGE. Thread: one. RT:
/// yes.
class InivationImu {
 public:
  /// `flips`: bit 2 negates x, bit 1 y, bit 0 z (IMU parameter 1).
  InivationImu(InivationFormat format, std::uint32_t flips) noexcept : format_(format), flips_(flips) {}

  void begin() noexcept;
  void configure(std::uint8_t data) noexcept;
  void add(std::uint8_t byte) noexcept;
  /// True when a whole sample was there; it gets the time `t_us`.
  bool end(std::int64_t t_us, ImuSample& sample, InivationCounters& counters) noexcept;

 private:
  static constexpr std::size_t kBytes = 14;

  [[nodiscard]] bool has_part_at(std::size_t byte) const noexcept;
  [[nodiscard]] std::size_t present_from(std::size_t byte) const noexcept;
  [[nodiscard]] double value(std::size_t first, int axis) const noexcept;

  InivationFormat format_;
  std::uint32_t flips_;
  std::uint8_t bytes_[kBytes] = {};
  std::size_t next_ = 0;  // place of the next byte; kBytes: complete; beyond: too many came
  bool is_open_ = false;
  bool is_configured_ = false;
  bool has_accel_ = false;
  bool has_temperature_ = false;
  bool has_gyro_ = false;
  double accel_m_s2_per_unit_ = 0;
  double gyro_rad_s_per_unit_ = 0;
};

}  // namespace egofocus
