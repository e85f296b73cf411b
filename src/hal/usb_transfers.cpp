#include "hal/usb_transfers.hpp"

namespace egofocus {

int UsbTransfers::prepare(UsbConnection& usb, std::span<std::byte> memory, std::size_t count,
                          std::size_t bytes) noexcept {
  for (count_ = 0; count_ < count; ++count_) {
    UsbTransfer& transfer = transfers_[count_];
    transfer = {.buffer = memory.subspan(count_ * bytes, bytes)};
    if (const int error = usb.prepare(transfer); error != 0) {
      release(usb);
      return error;
    }
  }
  oldest_ = 0;
  active_ = 0;
  return 0;
}

void UsbTransfers::release(UsbConnection& usb) noexcept {
  for (std::size_t i = 0; i < count_; ++i) usb.release(transfers_[i]);
  count_ = 0;
  active_ = 0;
}

int UsbTransfers::submit_all(UsbConnection& usb, std::uint8_t endpoint, unsigned timeout_ms) noexcept {
  oldest_ = 0;
  for (active_ = 0; active_ < count_; ++active_) {
    if (const int error = usb.submit(endpoint, transfers_[active_], timeout_ms); error != 0) return error;
  }
  return 0;
}

UsbTransfer* UsbTransfers::oldest_ended() noexcept {
  if (active_ == 0 || transfers_[oldest_].is_in_flight) return nullptr;
  return &transfers_[oldest_];
}

int UsbTransfers::resubmit(UsbConnection& usb, std::uint8_t endpoint, unsigned timeout_ms) noexcept {
  const int error = usb.submit(endpoint, transfers_[oldest_], timeout_ms);
  oldest_ = (oldest_ + 1) % count_;
  if (error != 0) --active_;
  return error;
}

void UsbTransfers::retire() noexcept {
  oldest_ = (oldest_ + 1) % count_;
  --active_;
}

void UsbTransfers::cancel(UsbConnection& usb) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (transfers_[i].is_in_flight) usb.cancel(transfers_[i]);
  }
}

bool UsbTransfers::any_in_flight() const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (transfers_[i].is_in_flight) return true;
  }
  return false;
}

}  // namespace egofocus
