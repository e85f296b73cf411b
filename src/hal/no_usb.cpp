#include "hal/usb_io.hpp"

namespace egofocus {

const UsbIo* system_usb() noexcept {
  return nullptr;
}

}  // namespace egofocus
