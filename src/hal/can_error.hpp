// Error frames of a CAN controller -> counters and the state of its node on the bus.
//
// Source: linux/can/error.h; the states are those of ISO 11898-1 (error active, passive, bus off).
#pragma once

#include <cstdint>
#include <span>

namespace egofocus {

enum class CanBusState : std::uint8_t {
  kActive,
  kWarning,  ///< an error counter above 96
  kPassive,  ///< above 127: what this node says about errors no longer counts
  kOff,      ///< above 255: the node is mute until it is restarted
};

/// "active", "warning", "passive", "off". Thread: any. RT: yes.
const char* to_string(CanBusState state) noexcept;

/// One frame may report several.
struct CanErrorCounters {
  std::uint64_t frames = 0;
  std::uint64_t rx_overflows =
      0;  ///< the controller's own buffer: frames were lost before the kernel saw them
  std::uint64_t tx_overflows = 0;
  std::uint64_t warnings = 0;
  std::uint64_t passive = 0;
  std::uint64_t bus_off = 0;
  std::uint64_t restarted = 0;
  std::uint64_t protocol = 0;  ///< bit, stuff, form, CRC and other violations
  std::uint64_t no_ack = 0;    ///< nobody else is on the bus, or the bit rate differs
  std::uint64_t bus_errors = 0;
  std::uint64_t transceiver = 0;  ///< wires
  std::uint64_t other = 0;        ///< arbitration lost, transmit time-out
  std::uint8_t tx_errors = 0;     ///< the controller's error counters, as last reported
  std::uint8_t rx_errors = 0;
};

/// Thread: one at a time. RT: yes.
class CanErrorDecoder {
 public:
  /// `classes`: the id of the frame without its flag bits. Bytes that a short frame lacks count as 0.
  void feed(std::uint32_t classes, std::span<const std::uint8_t> data) noexcept;

  /// A data frame came: a node that hears and acknowledges is not off.
  void hear() noexcept {
    if (state_ == CanBusState::kOff) state_ = CanBusState::kActive;
  }
  /// The interface was taken up anew. Counters stay.
  void restart() noexcept { state_ = CanBusState::kActive; }

  [[nodiscard]] CanBusState state() const noexcept { return state_; }
  [[nodiscard]] const CanErrorCounters& counters() const noexcept { return counters_; }

 private:
  void controller(std::uint8_t status) noexcept;

  CanBusState state_ = CanBusState::kActive;
  CanErrorCounters counters_;
};

}  // namespace egofocus
