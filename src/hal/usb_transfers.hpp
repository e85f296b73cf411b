// The bulk transfers of one endpoint: all in flight, taken and sent again in their order.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "hal/usb_connection.hpp"

namespace egofocus {

/// A ring of transfers over memory of the caller. The connection outlives what is in flight: order of calls
/// prepare -> submit_all -> [oldest_ended, resubmit | retire ...] -> cancel -> wait until none is in flight
/// -> (close the device) -> release. Thread: one. RT: oldest_ended, resubmit, retire, cancel yes as far as it
/// lies with us; see UsbIo::submit.
class UsbTransfers {
 public:
  static constexpr std::size_t kMost = 64;

  /// Precondition: 1 <= count <= kMost, memory holds count * bytes. ENOMEM leaves nothing behind.
  int prepare(UsbConnection& usb, std::span<std::byte> memory, std::size_t count, std::size_t bytes) noexcept;
  void release(UsbConnection& usb) noexcept;

  int submit_all(UsbConnection& usb, std::uint8_t endpoint, unsigned timeout_ms) noexcept;
  /// The one that was sent first among those not taken, once it ended; nullptr while it is in flight or when
  /// all were retired.
  [[nodiscard]] UsbTransfer* oldest_ended() noexcept;
  /// The oldest becomes the newest.
  int resubmit(UsbConnection& usb, std::uint8_t endpoint, unsigned timeout_ms) noexcept;
  /// The oldest is taken and not sent again.
  void retire() noexcept;

  void cancel(UsbConnection& usb) noexcept;
  [[nodiscard]] bool any_in_flight() const noexcept;
  /// Sent and not retired.
  [[nodiscard]] std::size_t active() const noexcept { return active_; }

 private:
  std::array<UsbTransfer, kMost> transfers_;
  std::size_t count_ = 0;
  std::size_t oldest_ = 0;
  std::size_t active_ = 0;
};

}  // namespace egofocus
