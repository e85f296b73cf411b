// The configuration port of iniVation's cameras: modules and parameters through vendor requests.
#pragma once

#include <cstdint>

#include "hal/usb_connection.hpp"

namespace egofocus {

/// Source: libcaer, src/usb_utils.h and usb_utils.c (vendor requests), include/libcaer/devices/davis.h and
/// dvxplorer.h (modules and parameters).
enum InivationModule : std::uint16_t {
  kMux = 0,
  kDvs = 1,
  kAps = 2,
  kImu = 3,
  kExternalInput = 4,
  kBias = 5,  ///< DAVIS: biases, from 128 on the chip's register; DVXplorer: the sensor's registers
  kSystemInfo = 6,
  kUsb = 9,
};

constexpr std::uint32_t inivation_address(InivationModule module, std::uint16_t parameter) noexcept {
  return static_cast<std::uint32_t>(module) << 16 | parameter;
}

/// One parameter. Returns 0 or an errno. Thread: one. RT: no.
int inivation_write(UsbConnection& usb, std::uint32_t address, std::uint32_t value) noexcept;
int inivation_read(UsbConnection& usb, std::uint32_t address, std::uint32_t& value) noexcept;
/// 1, then 0, without a gap between them.
int inivation_pulse(UsbConnection& usb, std::uint32_t address) noexcept;
/// A counter of 64 bits: upper half at `address`, lower half behind it.
int inivation_read64(UsbConnection& usb, std::uint32_t address, std::uint64_t& value) noexcept;

}  // namespace egofocus
