// Treuzell, the control protocol of Prophesee's evaluation kits: properties through a pair of bulk endpoints.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/usb_connection.hpp"

namespace egofocus {

/// Source: OpenEB, hal_psee_plugins/src/boards/treuzell (command definitions, control frame, libusb board
/// command).
enum TreuzellProperty : std::uint32_t {
  kSerialNumber = 0x72,
  kReleaseVersion = 0x79,
  kDeviceCount = 0x10000,
  kDeviceCompatible = 0x10003,
  kDeviceRegisters = 0x10102,
};

/// One request and its answer: the payload without the frame, `got` bytes of it. EPROTO: the camera refused,
/// or the answer is of another property or incomplete; EMSGSIZE: the answer has more than `answer` holds.
/// Thread: one. RT: no.
int treuzell_ask(UsbConnection& usb, TreuzellProperty property, std::span<const std::uint32_t> request,
                 std::span<std::byte> answer, std::size_t& got) noexcept;

/// A property of one number.
int treuzell_read_number(UsbConnection& usb, TreuzellProperty property, std::uint64_t& value) noexcept;

/// A register of the sensor, which is device 0.
int treuzell_read(UsbConnection& usb, std::uint32_t address, std::uint32_t& value) noexcept;
int treuzell_write(UsbConnection& usb, std::uint32_t address, std::uint32_t value) noexcept;

}  // namespace egofocus
