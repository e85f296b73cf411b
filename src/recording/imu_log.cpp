#include "recording/imu_log.hpp"

#include <array>
#include <bit>
#include <cstdio>
#include <utility>

#include "hal/candump_writer.hpp"
#include "recording/error.hpp"

namespace egofocus::recording {
namespace {

constexpr std::uint32_t kImuId = 0x110;
constexpr const char* kSignals[6] = {"GyroX", "GyroY", "GyroZ", "AccelX", "AccelY", "AccelZ"};
constexpr CanRole kRoles[6] = {CanRole::kGyroX,  CanRole::kGyroY,  CanRole::kGyroZ,
                               CanRole::kAccelX, CanRole::kAccelY, CanRole::kAccelZ};

void put_float(float value, std::uint8_t* out) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (int i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(bits >> (8 * i));
}

}  // namespace

ImuLog::ImuLog(std::filesystem::path path)
    : path_(std::move(path)), file_(path_, std::ios::binary | std::ios::trunc) {
  check();
}

void ImuLog::write(const ImuReading& reading) {
  CanFrame frame;
  frame.t_us = reading.t_us;
  frame.id = kImuId;
  frame.fd = true;
  frame.length = 24;
  for (int i = 0; i < 3; ++i) {
    put_float(reading.gyro[i], frame.data + 4 * i);
    put_float(reading.accel[i], frame.data + 12 + 4 * i);
  }
  std::array<char, kMaxCandumpLineBytes> line;
  const std::size_t size = write_candump_line(frame, "imu", line);
  if (size == 0) throw Error(ExitCode::kInternal, path_.string(), "an IMU sample has no line.");
  file_.write(line.data(), static_cast<std::streamsize>(size));
  check();
}

void ImuLog::close() {
  file_.close();
  check();
}

void ImuLog::check() const {
  if (!file_)
    throw Error(ExitCode::kFile, path_.string(), "cannot be written. May you write there, is the disk full?");
}

const char* imu_dbc_text() noexcept {
  return "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: IMU\n\n"
         "BO_ 272 IMU_SAMPLE: 24 IMU\n"
         " SG_ GyroX : 0|32@1- (1,0) [0|0] \"\" Vector__XXX\n"
         " SG_ GyroY : 32|32@1- (1,0) [0|0] \"\" Vector__XXX\n"
         " SG_ GyroZ : 64|32@1- (1,0) [0|0] \"\" Vector__XXX\n"
         " SG_ AccelX : 96|32@1- (1,0) [0|0] \"\" Vector__XXX\n"
         " SG_ AccelY : 128|32@1- (1,0) [0|0] \"\" Vector__XXX\n"
         " SG_ AccelZ : 160|32@1- (1,0) [0|0] \"\" Vector__XXX\n\n"
         "SIG_VALTYPE_ 272 GyroX : 1;\nSIG_VALTYPE_ 272 GyroY : 1;\nSIG_VALTYPE_ 272 GyroZ : 1;\n"
         "SIG_VALTYPE_ 272 AccelX : 1;\nSIG_VALTYPE_ 272 AccelY : 1;\nSIG_VALTYPE_ 272 AccelZ : 1;\n";
}

CanSetup imu_can_setup(CanUnit gyro, CanUnit accel) {
  CanSetup setup;
  setup.dbc = kImuDbcName;
  for (std::size_t i = 0; i < 6; ++i) {
    CanSignalRole& signal = setup.motion.signals[i];
    std::snprintf(signal.message, sizeof signal.message, "IMU_SAMPLE");
    std::snprintf(signal.signal, sizeof signal.signal, "%s", kSignals[i]);
    signal.role = kRoles[i];
    signal.unit = i < 3 ? gyro : accel;
  }
  setup.motion.signal_count = 6;
  return setup;
}

}  // namespace egofocus::recording
