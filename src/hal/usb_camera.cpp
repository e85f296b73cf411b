#include "hal/usb_camera.hpp"

#include "hal/device_status.hpp"

namespace egofocus {
namespace {

// libcaer docs/65-inivation.rules; OpenEB's udev rules and psee_libusb_board_command.cpp.
constexpr std::uint16_t kInivation = 0x152A;
constexpr std::uint16_t kDvxplorer = 0x8419;
constexpr std::uint16_t kDavisFx3 = 0x841A;
constexpr std::uint16_t kDavisFx2 = 0x841B;
constexpr std::uint16_t kCypress = 0x04B4;
constexpr std::uint16_t kEvk3 = 0x00F4;
constexpr std::uint16_t kEvk4 = 0x00F5;
constexpr std::uint16_t kXilinx = 0x03FD;
constexpr std::uint16_t kEvk2 = 0x5832;
constexpr std::uint8_t kVendorClass = 0xFF;
constexpr std::uint8_t kTreuzellSubclass = 0x19;
constexpr unsigned kMipiKind = 4;  // bcdDevice, high byte

}  // namespace

const UsbCameraDriver* driver_of(const UsbDevice& device, const char*& why_not) noexcept {
  why_not = "";
  if (device.vendor == kInivation) {
    if (device.product == kDavisFx3 || device.product == kDavisFx2) return &davis_driver();
    if (device.product == kDvxplorer && device.release >> 8 == kMipiKind) {
      why_not = "DVXplorer Mini (MIPI): how it is started is not documented";
      return nullptr;
    }
    if (device.product == kDvxplorer) return &dvxplorer_driver();
    why_not = "an iniVation device that is neither DAVIS nor DVXplorer";
  } else if (device.vendor == kCypress) {
    // The vendor id is shared by all who use this controller: the class tells the camera.
    const bool is_evk = device.product == kEvk3 || device.product == kEvk4;
    if (is_evk && device.interface_class == kVendorClass && device.interface_subclass == kTreuzellSubclass) {
      return &imx636_driver();
    }
    if (device.product == 0x8613 || device.product == 0x0053 || device.product == 0x00F3) {
      why_not =
          "a Cypress USB controller without firmware: if it is a DAVIS, its maker's tool writes it anew";
    }
  } else if (device.vendor == kXilinx && device.product == kEvk2) {
    why_not = "EVK2: not supported";
  }
  return nullptr;
}

// All but the DAVIS240, whose controller knows no faster link than USB 2.
bool is_slow_link(const UsbDevice& device) noexcept {
  const bool is_usb2_device = device.vendor == kInivation && device.product == kDavisFx2;
  return !is_usb2_device && device.speed != UsbSpeed::kSuper && device.speed != UsbSpeed::kUnknown;
}

Status open_camera(UsbConnection& usb, const UsbDevice& device, const UsbCameraDriver& driver,
                   UsbCameraInfo& info) noexcept {
  info.device = device;
  info.name = driver.family;
  info.firmware = device.release & 0xff;
  if (const int error = usb.open(device); error != 0) return device_status(error, driver.family);
  if (device.serial_index != 0) static_cast<void>(usb.text(device.serial_index, info.serial));
  if (const int error = usb.claim(); error != 0) return device_status(error, driver.family);
  return driver.identify(usb, info);
}

}  // namespace egofocus
