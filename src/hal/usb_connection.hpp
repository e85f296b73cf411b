// One opened USB device, closed by RAII whatever happened on the way.
#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/usb_io.hpp"

namespace egofocus {

/// Owns the bus and the device; half-open states close as well. Functions return 0 or an errno; each transfer
/// is bounded by kTimeout_ms. Thread: one. RT: no (set-up), but wait().
class UsbConnection {
 public:
  static constexpr unsigned kTimeout_ms = 1000;

  UsbConnection() noexcept = default;
  ~UsbConnection() { close(); }
  UsbConnection(const UsbConnection&) = delete;
  UsbConnection& operator=(const UsbConnection&) = delete;

  int open_bus(const UsbIo& io) noexcept {
    close();
    io_ = &io;
    return io.open_bus(io.self, bus_);
  }
  std::size_t list(std::span<UsbDevice> out) noexcept { return io_->list(io_->self, bus_, out); }
  int open(const UsbDevice& which) noexcept {
    close_device();
    return io_->open(io_->self, bus_, which, device_);
  }
  int claim() noexcept { return io_->claim(io_->self, device_); }
  void close_device() noexcept {
    if (device_ != nullptr) io_->close(io_->self, device_);
    device_ = nullptr;
  }
  void close() noexcept {
    close_device();
    if (bus_ != nullptr) io_->close_bus(io_->self, bus_);
    bus_ = nullptr;
  }
  [[nodiscard]] bool is_open() const noexcept { return device_ != nullptr; }

  int text(std::uint8_t index, std::span<char> out) noexcept {
    return io_->text(io_->self, device_, index, out);
  }
  int control(const UsbSetup& setup, std::span<std::byte> data, unsigned timeout_ms = kTimeout_ms) noexcept {
    return io_->control(io_->self, device_, setup, data, timeout_ms);
  }
  int bulk(std::uint8_t endpoint, std::span<std::byte> data, std::size_t& moved,
           unsigned timeout_ms = kTimeout_ms) noexcept {
    return io_->bulk(io_->self, device_, endpoint, data, moved, timeout_ms);
  }
  int clear_halt(std::uint8_t endpoint) noexcept { return io_->clear_halt(io_->self, device_, endpoint); }

  int prepare(UsbTransfer& transfer) noexcept { return io_->prepare(io_->self, transfer); }
  void release(UsbTransfer& transfer) noexcept { io_->release(io_->self, transfer); }
  int submit(std::uint8_t endpoint, UsbTransfer& transfer, unsigned timeout_ms) noexcept {
    return io_->submit(io_->self, device_, endpoint, transfer, timeout_ms);
  }
  void cancel(UsbTransfer& transfer) noexcept { io_->cancel(io_->self, transfer); }
  int wait(std::int64_t timeout_us) noexcept { return io_->wait(io_->self, bus_, timeout_us); }

 private:
  const UsbIo* io_ = nullptr;
  void* bus_ = nullptr;
  void* device_ = nullptr;
};

}  // namespace egofocus
