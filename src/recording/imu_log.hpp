// IMU samples of a converted recording: can.log and the DBC for it, which the converter writes as well.
//
// One CAN FD frame a sample: six IEEE floats, gyro x y z and accelerometer x y z, in the sensor's own unit,
// so that no digit is lost.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "recording/camera_toml.hpp"

namespace egofocus::recording {

inline constexpr const char* kImuDbcName = "imu.dbc";

struct ImuReading {
  std::int64_t t_us = 0;
  float gyro[3] = {0, 0, 0};
  float accel[3] = {0, 0, 0};
};

class ImuLog {
 public:
  /// Creates the file. Throws Error (kFile).
  explicit ImuLog(std::filesystem::path path);

  /// t_us >= 0. Throws Error (kFile).
  void write(const ImuReading& reading);

  /// Throws Error (kFile) when not all could be written.
  void close();

 private:
  void check() const;

  std::filesystem::path path_;
  std::ofstream file_;
};

/// The DBC of such a log.
[[nodiscard]] const char* imu_dbc_text() noexcept;

/// [can] of such a log: gyro and accelerometer in these units.
[[nodiscard]] CanSetup imu_can_setup(CanUnit gyro, CanUnit accel);

}  // namespace egofocus::recording
