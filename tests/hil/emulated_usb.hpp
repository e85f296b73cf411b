// The other side of a USB cable: a device that the kernel's own USB/IP driver (vhci-hcd) plugs into the
// guest; its drivers and libusb cannot tell. vhci-hcd takes any stream socket, so neither a network nor the
// usbip tools are needed.
//
// Source: Documentation/usb/usbip_protocol.rst, the URB messages (48 bytes, big-endian); USB 2.0, chapter 9
// (standard requests).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <thread>
#include <vector>

namespace egofocus::hil {

using Bytes = std::vector<std::uint8_t>;

/// Little-endian, as everything in USB's descriptors.
void add_u16(Bytes& bytes, std::uint32_t value);
void add_u32(Bytes& bytes, std::uint32_t value);

/// A control request's eight bytes, without its length.
struct Setup {
  std::uint8_t type = 0;
  std::uint8_t request = 0;
  std::uint16_t value = 0;
  std::uint16_t index = 0;
};

/// USB 2.0, one configuration; texts 1, 2, 3 are maker, product, serial. `device_class`: class, subclass,
/// protocol; 0: the interfaces tell theirs.
struct UsbIdentity {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::uint16_t release = 0;
  std::uint8_t device_class[3] = {};
  std::vector<std::string> texts;
};

/// A device of one configuration, at high speed. What it is comes from its descriptors; what it does, from
/// the virtual functions, which run on its own thread. Thread: plug, unplug from the test's.
class EmulatedUsb {
 public:
  /// `configuration`: with its interfaces and endpoints; the total length is filled in.
  EmulatedUsb(UsbIdentity identity, Bytes configuration);
  /// A derived class unplugs in its own destructor: its functions run until then.
  virtual ~EmulatedUsb() { unplug(); }
  EmulatedUsb(const EmulatedUsb&) = delete;
  EmulatedUsb& operator=(const EmulatedUsb&) = delete;

  /// Into a port (0..7) of the virtual controller. False when the kernel refuses.
  bool plug(int port = 0);
  /// The same after waiting until the kernel has given the port free, 20 s at most.
  bool plug_when_free(int port = 0);
  /// Pulled out by surprise, whatever is under way.
  void unplug();

 protected:
  /// A class or vendor request; `data` is what came with it, or becomes the answer. False: stalled.
  virtual bool control(const Setup& setup, Bytes& data) = 0;
  /// Data for one IN transfer of at most `most` bytes. 0: done, `data` may be short; EAGAIN: nothing yet;
  /// another errno ends the transfer.
  virtual int in(std::uint8_t endpoint, std::size_t most, Bytes& data) = 0;
  /// Data of an OUT transfer.
  virtual void out(std::uint8_t, const Bytes&) {}
  virtual void halt_cleared(std::uint8_t) {}

 private:
  struct Pending {
    std::uint32_t sequence = 0;
    std::uint32_t most = 0;
  };
  struct Header;

  void serve();
  bool take_message();
  bool cancel(const Header& header);
  bool answer_control(const Header& header, Bytes data);
  bool standard_request(const Setup& setup, Bytes& data);
  bool descriptor(int type, std::size_t index, Bytes& data) const;
  bool feed_pending();
  bool reply(std::uint32_t sequence, int status, const Bytes& data, std::uint32_t length);
  bool move(void* data, std::size_t bytes, bool is_writing);

  UsbIdentity identity_;
  Bytes configuration_;
  std::map<std::uint8_t, std::deque<Pending>> pending_;  // IN transfers that wait for data
  int socket_ = -1;
  std::atomic<bool> is_leaving_{false};
  std::thread thread_;
};

}  // namespace egofocus::hil
