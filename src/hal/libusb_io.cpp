#include <libusb.h>

#include <cerrno>

#include "hal/usb_io.hpp"

namespace egofocus {
namespace {

int errno_of(int code) noexcept {
  switch (code) {
    case LIBUSB_ERROR_ACCESS:
      return EACCES;
    case LIBUSB_ERROR_BUSY:
      return EBUSY;
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
      return ENODEV;
    case LIBUSB_ERROR_TIMEOUT:
      return ETIMEDOUT;
    case LIBUSB_ERROR_OVERFLOW:
      return EOVERFLOW;
    case LIBUSB_ERROR_PIPE:
      return EPIPE;
    case LIBUSB_ERROR_INTERRUPTED:
      return EINTR;
    case LIBUSB_ERROR_NO_MEM:
      return ENOMEM;
    case LIBUSB_ERROR_NOT_SUPPORTED:
      return ENOTSUP;
    case LIBUSB_ERROR_INVALID_PARAM:
      return EINVAL;
    default:
      return code < 0 ? EIO : 0;
  }
}

int errno_of(libusb_transfer_status status) noexcept {
  switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
      return 0;
    case LIBUSB_TRANSFER_TIMED_OUT:
      return ETIMEDOUT;
    case LIBUSB_TRANSFER_CANCELLED:
      return ECANCELED;
    case LIBUSB_TRANSFER_STALL:
      return EPIPE;
    case LIBUSB_TRANSFER_NO_DEVICE:
      return ENODEV;
    case LIBUSB_TRANSFER_OVERFLOW:
      return EOVERFLOW;
    default:
      return EIO;
  }
}

UsbSpeed speed_of(int speed) noexcept {
  switch (speed) {
    case LIBUSB_SPEED_LOW:
      return UsbSpeed::kLow;
    case LIBUSB_SPEED_FULL:
      return UsbSpeed::kFull;
    case LIBUSB_SPEED_HIGH:
      return UsbSpeed::kHigh;
    case LIBUSB_SPEED_UNKNOWN:
      return UsbSpeed::kUnknown;
    default:
      return UsbSpeed::kSuper;
  }
}

libusb_context* context(void* bus) noexcept {
  return static_cast<libusb_context*>(bus);
}
libusb_device_handle* handle(void* device) noexcept {
  return static_cast<libusb_device_handle*>(device);
}
libusb_transfer* native(UsbTransfer& transfer) noexcept {
  return static_cast<libusb_transfer*>(transfer.native);
}
unsigned char* raw(std::span<std::byte> bytes) noexcept {
  return reinterpret_cast<unsigned char*>(bytes.data());
}

int open_bus(void*, void*& bus) noexcept {
  libusb_context* made = nullptr;
  const int error = errno_of(libusb_init(&made));
  bus = made;
  return error;
}
void close_bus(void*, void* bus) noexcept {
  libusb_exit(context(bus));
}

UsbDevice describe(libusb_device* device) noexcept {
  UsbDevice told{.bus = libusb_get_bus_number(device),
                 .address = libusb_get_device_address(device),
                 .speed = speed_of(libusb_get_device_speed(device))};
  libusb_device_descriptor all{};
  if (libusb_get_device_descriptor(device, &all) == 0) {
    told.vendor = all.idVendor;
    told.product = all.idProduct;
    told.release = all.bcdDevice;
    told.serial_index = all.iSerialNumber;
  }
  libusb_config_descriptor* active = nullptr;
  if (libusb_get_active_config_descriptor(device, &active) == 0) {
    if (active->bNumInterfaces > 0 && active->interface[0].num_altsetting > 0) {
      told.interface_class = active->interface[0].altsetting[0].bInterfaceClass;
      told.interface_subclass = active->interface[0].altsetting[0].bInterfaceSubClass;
    }
    libusb_free_config_descriptor(active);
  }
  return told;
}

std::size_t list(void*, void* bus, std::span<UsbDevice> out) noexcept {
  libusb_device** devices = nullptr;
  const ssize_t found = libusb_get_device_list(context(bus), &devices);
  if (found < 0) return 0;
  const auto count = static_cast<std::size_t>(found);
  for (std::size_t i = 0; i < count && i < out.size(); ++i) out[i] = describe(devices[i]);
  libusb_free_device_list(devices, 1);
  return count;
}

int open(void*, void* bus, const UsbDevice& which, void*& device) noexcept {
  libusb_device** devices = nullptr;
  const ssize_t found = libusb_get_device_list(context(bus), &devices);
  if (found < 0) return errno_of(static_cast<int>(found));
  int error = ENODEV;
  for (ssize_t i = 0; i < found; ++i) {
    if (libusb_get_bus_number(devices[i]) != which.bus ||
        libusb_get_device_address(devices[i]) != which.address) {
      continue;
    }
    libusb_device_handle* opened = nullptr;
    error = errno_of(libusb_open(devices[i], &opened));
    device = opened;
    break;
  }
  libusb_free_device_list(devices, 1);
  return error;
}
void close(void*, void* device) noexcept {
  libusb_close(handle(device));
}
int claim(void*, void* device) noexcept {
  return errno_of(libusb_claim_interface(handle(device), 0));
}

int text(void*, void* device, std::uint8_t index, std::span<char> out) noexcept {
  const int length = libusb_get_string_descriptor_ascii(
      handle(device), index, reinterpret_cast<unsigned char*>(out.data()), static_cast<int>(out.size()) - 1);
  if (length < 0) return errno_of(length);
  out[static_cast<std::size_t>(length)] = '\0';
  return 0;
}

int control(void*, void* device, const UsbSetup& setup, std::span<std::byte> data,
            unsigned timeout_ms) noexcept {
  const int moved =
      libusb_control_transfer(handle(device), setup.type, setup.request, setup.value, setup.index, raw(data),
                              static_cast<std::uint16_t>(data.size()), timeout_ms);
  if (moved < 0) return errno_of(moved);
  return static_cast<std::size_t>(moved) == data.size() ? 0 : EIO;
}

int bulk(void*, void* device, std::uint8_t endpoint, std::span<std::byte> data, std::size_t& moved,
         unsigned timeout_ms) noexcept {
  int bytes = 0;
  const int code = libusb_bulk_transfer(handle(device), endpoint, raw(data), static_cast<int>(data.size()),
                                        &bytes, timeout_ms);
  moved = static_cast<std::size_t>(bytes);
  return errno_of(code);
}
int clear_halt(void*, void* device, std::uint8_t endpoint) noexcept {
  return errno_of(libusb_clear_halt(handle(device), endpoint));
}

// Runs inside wait() and inside control(), on the thread that called them.
void LIBUSB_CALL ended(libusb_transfer* done) {
  auto& transfer = *static_cast<UsbTransfer*>(done->user_data);
  transfer.length = static_cast<std::size_t>(done->actual_length);
  transfer.error = errno_of(done->status);
  transfer.is_in_flight = false;
}

int prepare(void*, UsbTransfer& transfer) noexcept {
  transfer.native = libusb_alloc_transfer(0);
  return transfer.native == nullptr ? ENOMEM : 0;
}
void release(void*, UsbTransfer& transfer) noexcept {
  libusb_free_transfer(native(transfer));
  transfer.native = nullptr;
}
int submit(void*, void* device, std::uint8_t endpoint, UsbTransfer& transfer, unsigned timeout_ms) noexcept {
  libusb_fill_bulk_transfer(native(transfer), handle(device), endpoint, raw(transfer.buffer),
                            static_cast<int>(transfer.buffer.size()), ended, &transfer, timeout_ms);
  const int error = errno_of(libusb_submit_transfer(native(transfer)));
  transfer.is_in_flight = error == 0;
  return error;
}
void cancel(void*, UsbTransfer& transfer) noexcept {
  libusb_cancel_transfer(native(transfer));
}
int wait(void*, void* bus, std::int64_t timeout_us) noexcept {
  timeval limit{.tv_sec = static_cast<time_t>(timeout_us / 1'000'000),
                .tv_usec = static_cast<suseconds_t>(timeout_us % 1'000'000)};
  return errno_of(libusb_handle_events_timeout_completed(context(bus), &limit, nullptr));
}

constexpr UsbIo kSystem{.self = nullptr,
                        .open_bus = open_bus,
                        .close_bus = close_bus,
                        .list = list,
                        .open = open,
                        .close = close,
                        .claim = claim,
                        .text = text,
                        .control = control,
                        .bulk = bulk,
                        .clear_halt = clear_halt,
                        .prepare = prepare,
                        .release = release,
                        .submit = submit,
                        .cancel = cancel,
                        .wait = wait};

}  // namespace

const UsbIo* system_usb() noexcept {
  return &kSystem;
}

}  // namespace egofocus
