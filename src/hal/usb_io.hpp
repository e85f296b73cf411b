// USB as the cameras need it, behind function pointers: one body over libusb, another one in the tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace egofocus {

enum class UsbSpeed : std::uint8_t { kUnknown, kLow, kFull, kHigh, kSuper };

/// What a device's descriptors say before it is opened.
struct UsbDevice {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::uint16_t release = 0;  ///< bcdDevice
  std::uint8_t bus = 0;
  std::uint8_t address = 0;
  std::uint8_t interface_class = 0;  ///< of interface 0
  std::uint8_t interface_subclass = 0;
  std::uint8_t serial_index = 0;  ///< of the serial number's string; 0: none
  UsbSpeed speed = UsbSpeed::kUnknown;
};

/// One bulk IN transfer. `error` is 0 or an errno: ETIMEDOUT, EPIPE (stall), EOVERFLOW (more than fits),
/// ENODEV (unplugged), ECANCELED, EIO; `length` bytes came in any case.
struct UsbTransfer {
  std::span<std::byte> buffer;
  std::size_t length = 0;
  int error = 0;
  bool is_in_flight = false;
  void* native = nullptr;
};

struct UsbSetup {
  std::uint8_t type = 0;  ///< bmRequestType; bit 7: device to host
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

/// Every function that can fail returns 0 or an errno. `bus` and `device` are opaque. Set-up functions may
/// allocate and take as long as their `timeout_ms`; of the rest the comment at the function says it.
/// Thread: one per bus.
struct UsbIo {
  void* self = nullptr;

  int (*open_bus)(void* self, void*& bus) noexcept = nullptr;
  void (*close_bus)(void* self, void* bus) noexcept = nullptr;
  /// Writes as many as fit and returns how many there are.
  std::size_t (*list)(void* self, void* bus, std::span<UsbDevice> out) noexcept = nullptr;
  /// EACCES: no permission; ENODEV: gone.
  int (*open)(void* self, void* bus, const UsbDevice& which, void*& device) noexcept = nullptr;
  void (*close)(void* self, void* device) noexcept = nullptr;
  /// Interface 0. EBUSY: somebody else has it.
  int (*claim)(void* self, void* device) noexcept = nullptr;
  /// String descriptor as ASCII with a final NUL.
  int (*text)(void* self, void* device, std::uint8_t index, std::span<char> out) noexcept = nullptr;
  /// All of `data` or an error.
  int (*control)(void* self, void* device, const UsbSetup& setup, std::span<std::byte> data,
                 unsigned timeout_ms) noexcept = nullptr;
  int (*bulk)(void* self, void* device, std::uint8_t endpoint, std::span<std::byte> data, std::size_t& moved,
              unsigned timeout_ms) noexcept = nullptr;
  int (*clear_halt)(void* self, void* device, std::uint8_t endpoint) noexcept = nullptr;

  /// What `submit` needs beside the buffer; freed by `release`, after the device was closed.
  int (*prepare)(void* self, UsbTransfer& transfer) noexcept = nullptr;
  void (*release)(void* self, UsbTransfer& transfer) noexcept = nullptr;
  /// Sets is_in_flight; 0 ms: no time-out. libusb allocates here (its kernel requests), we do not.
  int (*submit)(void* self, void* device, std::uint8_t endpoint, UsbTransfer& transfer,
                unsigned timeout_ms) noexcept = nullptr;
  void (*cancel)(void* self, UsbTransfer& transfer) noexcept = nullptr;
  /// Waits until a transfer ends, an interruption (EINTR) or the time-out, and clears is_in_flight of all
  /// that ended.
  int (*wait)(void* self, void* bus, std::int64_t timeout_us) noexcept = nullptr;
};

/// The system's USB through libusb; nullptr in a build without it (CMake option EGOFOCUS_USB). Thread: any.
/// RT: yes.
const UsbIo* system_usb() noexcept;

}  // namespace egofocus
