#include "hal/inivation_logic.hpp"

#include "hal/device_status.hpp"

namespace egofocus {
namespace {

constexpr std::uint32_t kEarlyPacket_us = 8 * 125;

// Reads one parameter after the other; after an error nothing more is read.
class Reader {
 public:
  explicit Reader(UsbConnection& usb) noexcept : usb_(usb) {}
  std::uint32_t operator()(InivationModule module, std::uint16_t parameter) noexcept {
    std::uint32_t value = 0;
    if (error_ == 0) error_ = inivation_read(usb_, inivation_address(module, parameter), value);
    return error_ == 0 ? value : 0;
  }
  [[nodiscard]] int error() const noexcept { return error_; }

 private:
  UsbConnection& usb_;
  int error_ = 0;
};

bool fits(std::uint32_t pixels) noexcept {
  return pixels >= 8 && pixels <= 1280;
}

}  // namespace

Status identify_inivation(InivationFormat format, std::uint32_t min_patch, std::uint32_t min_firmware,
                          UsbConnection& usb, UsbCameraInfo& info) noexcept {
  Reader read(usb);
  info.logic = read(kSystemInfo, kLogicVersion);
  if (read.error() == ENODEV) return device_status(ENODEV, info.name);
  if (read.error() != 0)
    return {StatusCode::kUnknownFirmware, "the logic's version, which the camera does not tell,", 0,
            kInivationLogic};
  info.patch = read(kSystemInfo, kLogicPatch);
  if (info.logic != kInivationLogic)
    return {StatusCode::kUnknownFirmware, "the logic's version", info.logic, kInivationLogic};
  if (info.patch < min_patch)
    return {StatusCode::kUnknownFirmware, "the logic's patch level", info.patch, min_patch};
  if (info.firmware < min_firmware)
    return {StatusCode::kUnknownFirmware, "the USB firmware", info.firmware, min_firmware};

  info.chip = read(kSystemInfo, kChipId);
  info.is_clock_master = read(kSystemInfo, kIsClockMaster) != 0;
  info.has_statistics = read(kMux, kMuxHasStatistics) != 0;
  const std::uint32_t deviation = read(kSystemInfo, kClockDeviation);
  info.usb_clock_khz = read(kSystemInfo, kUsbClock_mhz) * (deviation == 0 ? 1000 : deviation);
  const std::uint32_t columns = read(kDvs, kDvsColumns);
  const std::uint32_t rows = read(kDvs, kDvsRows);
  info.layout = {.format = format,
                 .sent = {static_cast<std::uint16_t>(columns), static_cast<std::uint16_t>(rows)},
                 .swaps_xy = (read(kDvs, kDvsOrientation) & 4) != 0,
                 .imu_flips = read(kImu, kImuOrientation)};
  info.size = info.layout.size();
  if (read.error() != 0) return device_status(read.error(), info.name);
  if (!fits(columns) || !fits(rows)) {
    return {StatusCode::kUnsupportedDevice, "its sensor size lies outside 8..1280"};
  }
  return {};
}

void add_inivation_off(UsbSteps& steps) noexcept {
  steps.write(inivation_address(kDvs, kDvsRun), 0);
  steps.write(inivation_address(kImu, kImuRunAccel), 0);
  steps.write(inivation_address(kImu, kImuRunGyro), 0);
  steps.write(inivation_address(kImu, kImuRunTemperature), 0);
  steps.write(inivation_address(kExternalInput, kExternalInputRun), 0);
  steps.write(inivation_address(kMux, kMuxRun), 0);
  steps.write(inivation_address(kMux, kMuxTimeRun), 0);
  steps.write(inivation_address(kUsb, kUsbRun), 0);
}

void add_inivation_stream(const UsbCameraInfo& info, UsbSteps& steps) noexcept {
  steps.write(inivation_address(kUsb, kUsbRun), 1);
  steps.write(inivation_address(kMux, kMuxTimeRun), 1);
  steps.write(inivation_address(kMux, kMuxRun), 1);
  steps.wait(50'000);
  // Events before this mark may be left-overs. A slave's time belongs to its master.
  if (info.is_clock_master)
    steps.add({.kind = UsbStepKind::kPulse, .address = inivation_address(kMux, kMuxTimeReset)});
}

void add_inivation_sensors(const UsbCameraSettings& settings, UsbSteps& steps) noexcept {
  steps.write(inivation_address(kDvs, kDvsRun), 1);
  if (!settings.imu) return;
  steps.write(inivation_address(kImu, kImuRunAccel), 1);
  steps.write(inivation_address(kImu, kImuRunGyro), 1);
  steps.write(inivation_address(kImu, kImuRunTemperature), 1);
}

void add_inivation_drop_policy(UsbSteps& steps) noexcept {
  steps.write(inivation_address(kMux, kMuxTimeReset), 0);
  steps.write(inivation_address(kMux, kMuxDropExternalInput), 1);
  steps.write(inivation_address(kMux, kMuxDropDvs), 1);
}

void add_inivation_early_packet(const UsbCameraInfo& info, UsbSteps& steps) noexcept {
  const std::uint64_t cycles = std::uint64_t{info.usb_clock_khz} * kEarlyPacket_us / 1000;
  steps.write(inivation_address(kUsb, kUsbEarlyPacket), static_cast<std::uint32_t>(cycles));
}

int read_inivation_dropped(UsbConnection& usb, std::uint64_t& events) noexcept {
  return inivation_read64(usb, inivation_address(kMux, kMuxDvsDropped), events);
}

}  // namespace egofocus
