#include "hal/can_error.hpp"

#include <linux/can/error.h>

#include <cstddef>

namespace egofocus {
namespace {

// Younger kernel headers name it.
constexpr std::uint32_t kErrorCountersClass = 0x200;

}  // namespace

const char* to_string(CanBusState state) noexcept {
  switch (state) {
    case CanBusState::kActive:
      return "active";
    case CanBusState::kWarning:
      return "warning";
    case CanBusState::kPassive:
      return "passive";
    case CanBusState::kOff:
      return "off";
  }
  return "unknown";
}

// The worst of what is reported counts: a frame may carry warning and passive together.
void CanErrorDecoder::controller(std::uint8_t status) noexcept {
  CanErrorCounters& n = counters_;
  n.rx_overflows += (status & CAN_ERR_CRTL_RX_OVERFLOW) != 0;
  n.tx_overflows += (status & CAN_ERR_CRTL_TX_OVERFLOW) != 0;
  const bool passive = (status & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0;
  const bool warning = (status & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0;
  n.passive += passive;
  n.warnings += warning;
  if (passive) {
    state_ = CanBusState::kPassive;
  } else if (warning) {
    state_ = CanBusState::kWarning;
  } else if ((status & CAN_ERR_CRTL_ACTIVE) != 0) {
    state_ = CanBusState::kActive;
  }
}

void CanErrorDecoder::feed(std::uint32_t classes, std::span<const std::uint8_t> data) noexcept {
  const auto byte = [data](std::size_t i) { return i < data.size() ? data[i] : std::uint8_t{0}; };
  CanErrorCounters& n = counters_;
  ++n.frames;
  if ((classes & CAN_ERR_CRTL) != 0) controller(byte(1));
  n.protocol += (classes & CAN_ERR_PROT) != 0;
  n.transceiver += (classes & CAN_ERR_TRX) != 0;
  n.no_ack += (classes & CAN_ERR_ACK) != 0;
  n.bus_errors += (classes & CAN_ERR_BUSERROR) != 0;
  n.other += (classes & (CAN_ERR_TX_TIMEOUT | CAN_ERR_LOSTARB)) != 0;
  if ((classes & kErrorCountersClass) != 0) {
    n.tx_errors = byte(6);
    n.rx_errors = byte(7);
  }
  if ((classes & CAN_ERR_RESTARTED) != 0) {
    ++n.restarted;
    state_ = CanBusState::kActive;
  }
  if ((classes & CAN_ERR_BUSOFF) != 0) {
    ++n.bus_off;
    state_ = CanBusState::kOff;
  }
}

}  // namespace egofocus
