// A CAN adapter that speaks the gs_usb protocol, as candleLight and CANable do: the kernel's gs_usb driver
// makes an interface of it, with bit timing, error states and hardware time stamps, which a virtual bus has
// not.
#pragma once

#include <cstdint>
#include <deque>
#include <initializer_list>
#include <mutex>
#include <span>

#include "hil/emulated_usb.hpp"

namespace egofocus::hil {

/// Source: linux/drivers/net/can/usb/gs_usb.c (requests, struct gs_host_frame).
class EmulatedCanAdapter : public EmulatedUsb {
 public:
  EmulatedCanAdapter();
  ~EmulatedCanAdapter() override { unplug(); }

  /// A frame from the bus, and an error frame, stamped with the adapter's clock. `id` has CAN_EFF_FLAG for 29
  /// bits. Nothing happens while the interface is down. Thread: any.
  void frame(std::uint32_t id, std::span<const std::uint8_t> data) { send(id, data, clock_us()); }
  void error(std::uint32_t classes, std::initializer_list<std::uint8_t> data);
  /// The same with a stamp of the caller's.
  void frame_at(std::uint32_t stamp_us, std::uint32_t id, std::span<const std::uint8_t> data) {
    send(id, data, stamp_us);
  }

 protected:
  bool control(const Setup& setup, Bytes& data) override;
  int in(std::uint8_t endpoint, std::size_t most, Bytes& data) override;
  void out(std::uint8_t endpoint, const Bytes& data) override;

 private:
  void send(std::uint32_t id, std::span<const std::uint8_t> data, std::uint32_t stamp_us);
  static std::uint32_t clock_us();

  std::mutex mutex_;
  bool is_started_ = false;
  bool has_stamps_ = false;
  std::deque<Bytes> queue_;
};

}  // namespace egofocus::hil
