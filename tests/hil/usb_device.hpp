// A USB device that exists in software alone, served to the guest's own kernel: its drivers and libusb cannot
// tell.
//
// The kernel's virtual host controller (vhci-hcd) takes one end of a socket and sends each request of a
// driver over it. Source: Documentation/usb/usbip_protocol.rst (the URB part; all numbers big-endian, 48-byte
// headers) and the USB 2.0 specification, chapter 9 (standard requests).
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace egofocus::hil {

using Bytes = std::vector<std::uint8_t>;

/// A control request's eight bytes.
struct Setup {
  std::uint8_t type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
  std::uint16_t length = 0;
};

/// What a device answers. One thread calls all of it.
class UsbDevice {
 public:
  virtual ~UsbDevice() = default;
  /// Vendor and class requests; false stalls.
  virtual bool control(const Setup& setup, std::span<const std::uint8_t> sent, Bytes& answer) = 0;
  /// Bulk data for the device.
  virtual void take(std::uint8_t endpoint, std::span<const std::uint8_t> data) = 0;
  /// At most `room` bytes of bulk data from the device; false: nothing yet.
  virtual bool give(std::uint8_t endpoint, std::size_t room, Bytes& data) = 0;
  /// A line of text from the test, such as a fault to show.
  virtual void command(const std::string& line) = 0;

  Bytes device_descriptor;
  Bytes configuration;               ///< configuration, interfaces, endpoints; its total length is filled in
  std::vector<std::string> strings;  ///< from number 1
  std::uint32_t speed = 3;           ///< 3: high speed (linux/usb/ch9.h)
};

/// device_descriptor of a device whose interfaces tell their class; strings 1, 2, 3: maker, product, serial.
Bytes device_descriptor(std::uint16_t vendor, std::uint16_t product, std::uint16_t release);

/// Plugs the device into port 0 of the virtual controller and serves it until `unplug` comes from the pipe
/// `commands` (made here; a line a command), or the kernel lets go of it. 0, or 1 with a line on stderr.
int plug_in(UsbDevice& device, const char* commands);

}  // namespace egofocus::hil
