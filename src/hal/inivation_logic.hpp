// What DAVIS and DVXplorer do alike: versions, size, the parts that run, what was dropped.
#pragma once

#include <cstdint>

#include "hal/inivation_port.hpp"
#include "hal/usb_camera.hpp"

namespace egofocus {

/// Source: libcaer, include/libcaer/devices/davis.h (parameters of each module).
enum InivationParameter : std::uint16_t {
  kMuxRun = 0,
  kMuxTimeRun = 1,
  kMuxTimeReset = 2,
  kMuxRunChip = 3,
  kMuxDropExternalInput = 4,
  kMuxDropDvs = 5,
  kMuxHasStatistics = 80,
  kMuxDvsDropped = 83,
  kDvsColumns = 0,
  kDvsRows = 1,
  kDvsOrientation = 2,
  kDvsRun = 3,
  kImuOrientation = 1,
  kImuRunAccel = 2,
  kImuRunGyro = 3,
  kImuRunTemperature = 4,
  kExternalInputRun = 0,
  kLogicVersion = 0,
  kChipId = 1,
  kIsClockMaster = 2,
  kUsbClock_mhz = 5,
  kClockDeviation = 6,  ///< thousandths of the nominal clock
  kLogicPatch = 7,
  kUsbRun = 0,
  kUsbEarlyPacket = 1,
};

/// The one logic that libcaer knows; firmware from 1.0 on speaks another, undocumented protocol.
inline constexpr std::uint32_t kInivationLogic = 18;

/// Reads what UsbCameraInfo has of iniVation. kUnknownFirmware when logic, patch or firmware is not known, or
/// the port does not answer; kDeviceLost. Thread: one. RT: no.
Status identify_inivation(InivationFormat format, std::uint32_t min_patch, std::uint32_t min_firmware,
                          UsbConnection& usb, UsbCameraInfo& info) noexcept;

/// All off, which also ends what a crashed process left running. The pixels' power stays with the caller.
void add_inivation_off(UsbSteps& steps) noexcept;
/// USB, time and multiplexer on, 50 ms, time to zero where this camera is the master.
void add_inivation_stream(const UsbCameraInfo& info, UsbSteps& steps) noexcept;
/// Pixels and, if asked for, the IMU on.
void add_inivation_sensors(const UsbCameraSettings& settings, UsbSteps& steps) noexcept;
/// When the host is slow the camera drops and counts instead of stopping.
void add_inivation_drop_policy(UsbSteps& steps) noexcept;
/// Short packets after 8 units of 125 us: nothing waits longer than 1 ms for its packet to fill.
void add_inivation_early_packet(const UsbCameraInfo& info, UsbSteps& steps) noexcept;

int read_inivation_dropped(UsbConnection& usb, std::uint64_t& events) noexcept;

}  // namespace egofocus
