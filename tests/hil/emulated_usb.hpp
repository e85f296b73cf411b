// The other side of a USB cable: a device that the kernel's own USB/IP driver (vhci-hcd) plugs into the
// guest. Protocol: Documentation/usb/usbip_protocol.rst, the URB messages (48 bytes, big-endian). vhci-hcd
// takes any stream socket, so neither a network nor the usbip tools are needed.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <thread>
#include <vector>

namespace hil {

using Bytes = std::vector<std::uint8_t>;

struct Setup {
  std::uint8_t type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

/// A device of one configuration. What it is comes from its descriptors; what it does, from the three
/// functions, which run on its own thread. Thread: plug, unplug and is_plugged from the test's.
class EmulatedUsb {
 public:
  enum class Speed : int { kHigh = 3, kSuper = 5 };

  EmulatedUsb(Bytes device_descriptor, Bytes configuration, std::vector<std::string> texts);
  virtual ~EmulatedUsb() { unplug(); }
  EmulatedUsb(const EmulatedUsb&) = delete;
  EmulatedUsb& operator=(const EmulatedUsb&) = delete;

  /// False when the kernel refuses.
  bool plug(int port = 0);
  /// Pulled out by surprise, whatever is under way.
  void unplug();

 protected:
  /// A vendor request; `data` is what came with it, or becomes the answer. False: stalled.
  virtual bool control(const Setup& setup, Bytes& data) = 0;
  /// Data for one IN transfer of at most `most` bytes. 0: done, `data` may be short; EAGAIN: nothing yet;
  /// another errno ends the transfer.
  virtual int in(std::uint8_t endpoint, std::size_t most, Bytes& data) = 0;
  virtual void halt_cleared(std::uint8_t endpoint) = 0;

 private:
  struct Pending {
    std::uint32_t sequence = 0;
    std::uint32_t most = 0;
  };
  struct Header;

  void serve();
  bool take_message();
  bool answer_control(const Header& header, Bytes data);
  bool standard_request(const Setup& setup, Bytes& data);
  bool feed_pending();
  bool reply(std::uint32_t sequence, int status, const Bytes& data, std::uint32_t length);
  bool move(void* data, std::size_t bytes, bool is_writing);

  Bytes device_descriptor_;
  Bytes configuration_;
  std::vector<std::string> texts_;
  std::map<std::uint8_t, std::deque<Pending>> pending_;  // IN transfers that wait for data
  int socket_ = -1;
  std::atomic<bool> is_leaving_{false};
  std::thread thread_;
};

}  // namespace hil
