// Room for what one recvmmsg() of a CAN socket brings, and its meaning.
//
// Source: linux/can.h (struct can_frame and canfd_frame, told apart by their length),
// Documentation/networking/ can.rst, Documentation/networking/timestamping.rst (SCM_TIMESTAMPING: three
// times, software first, raw hardware last).
#pragma once

#include <sys/socket.h>

#include <cstddef>
#include <cstdint>

#include "hal/can_frame.hpp"

namespace egofocus {

/// A message of the kernel. `frame.t_us` is not set here.
struct CanMessage {
  enum class Kind : std::uint8_t {
    kData,
    kRemote,
    kError,      ///< frame.id has the error classes
    kMalformed,  ///< neither struct, or a length beyond its kind
  };
  Kind kind = Kind::kMalformed;
  CanFrame frame;
  std::int64_t software_ns = 0;  ///< CLOCK_REALTIME; 0: none
  std::int64_t hardware_ns = 0;  ///< the controller's own clock; 0: none
  bool has_drops = false;
  std::uint32_t drops = 0;  ///< frames that the socket lost since it was opened, modulo 2^32
};

/// Thread: one at a time. RT: yes.
class SocketCanBatch {
 public:
  static constexpr unsigned kMessages = 32;

  /// Empty headers for the next recvmmsg(), kMessages of them. They point into this object.
  mmsghdr* prepare() noexcept;

  /// Message i of those that came.
  [[nodiscard]] CanMessage message(unsigned i) const noexcept;

 private:
  static constexpr std::size_t kFrameBytes = 72;     // CANFD_MTU
  static constexpr std::size_t kControlBytes = 128;  // three timespecs and a drop counter need 88

  mmsghdr headers_[kMessages] = {};
  iovec vectors_[kMessages] = {};
  alignas(8) unsigned char frames_[kMessages][kFrameBytes] = {};
  alignas(8) unsigned char controls_[kMessages][kControlBytes] = {};
};

}  // namespace egofocus
