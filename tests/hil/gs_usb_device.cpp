// A CAN adapter that speaks the gs_usb protocol, as candleLight and CANable do: the kernel's gs_usb driver
// makes an interface of it, with bit timing, error states and hardware time stamps, which a virtual bus has
// not.
//
//   gs_usb_device PIPE      lines to the pipe: frame ID HEX | error CLASSES HEX | clock_jump MICROSECONDS |
//   unplug
//
// Source: linux/drivers/net/can/usb/gs_usb.c (requests, struct gs_host_frame).
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <deque>

#include "hil/usb_device.hpp"

namespace {

using namespace egofocus::hil;

constexpr std::uint8_t kMode = 2, kBtConst = 4, kDeviceConfig = 5, kTimestamp = 6;  // enum gs_usb_breq
constexpr std::uint32_t kListenOnly = 1, kLoopBack = 2, kOneShot = 8, kHardwareTime = 16;
constexpr std::uint32_t kFromBus = 0xffffffff;  // echo_id of a frame that this adapter did not send
constexpr std::uint32_t kErrorFrame = 0x20000000;

void add_u32(Bytes& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

class CanAdapter : public UsbDevice {
 public:
  CanAdapter() {
    device_descriptor = egofocus::hil::device_descriptor(0x1d50, 0x606f, 0x0001);
    strings = {"egofocus tests", "gs_usb adapter", "1"};
    configuration = {9, 2, 0,    0, 1, 1,    0,    0x80, 50,  // one interface
                     9, 4, 0,    0, 2, 0xff, 0xff, 0xff, 0,   // of the vendor's class, two endpoints
                     7, 5, 0x81, 2, 0, 2,    0,               // bulk in, 512 bytes
                     7, 5, 0x02, 2, 0, 2,    0};              // bulk out
  }

  bool control(const Setup& setup, std::span<const std::uint8_t> sent, Bytes& answer) override {
    switch (setup.request) {
      case kMode:
        if (sent.size() >= 8) {
          started_ = sent[0] == 1;
          stamps_ = (sent[4] & kHardwareTime) != 0;
          queue_.clear();
          std::printf("adapter %s\n", started_ ? "started" : "stopped");
          std::fflush(stdout);
        }
        return true;
      case kBtConst:  // features, clock, then tseg1, tseg2, sjw, brp: least, most, step
        for (const std::uint32_t v : {kListenOnly | kLoopBack | kOneShot | kHardwareTime, 48000000u, 1u, 16u,
                                      1u, 8u, 4u, 1u, 1024u, 1u})
          add_u32(answer, v);
        return true;
      case kDeviceConfig:
        add_u32(answer, 0);  // one channel
        add_u32(answer, 2);
        add_u32(answer, 1);
        return true;
      case kTimestamp:
        add_u32(answer, clock_us());
        return true;
      default:
        return (setup.type & 0x80) == 0;  // host format, bit timing: taken
    }
  }

  void take(std::uint8_t,
            std::span<const std::uint8_t> data) override {  // what the host sends, echoed as sent
    if (data.size() < 20) return;
    Bytes echo(data.begin(), data.begin() + 20);
    if (stamps_) add_u32(echo, clock_us());
    queue_.push_back(echo);
  }

  bool give(std::uint8_t, std::size_t, Bytes& data) override {
    if (queue_.empty() || !started_) return false;
    data = queue_.front();
    queue_.pop_front();
    return true;
  }

  void command(const std::string& line) override {
    char kind[16] = "", id[16] = "", hex[20] = "";
    std::sscanf(line.c_str(), "%15s %15s %19s", kind, id, hex);
    if (std::strcmp(kind, "clock_jump") == 0)
      clock_jump_us_ += static_cast<std::uint32_t>(std::strtol(id, nullptr, 10));
    const bool error = std::strcmp(kind, "error") == 0;
    if (!error && std::strcmp(kind, "frame") != 0) return;
    Bytes frame;
    add_u32(frame, kFromBus);
    add_u32(frame, static_cast<std::uint32_t>(std::strtoul(id, nullptr, 16)) | (error ? kErrorFrame : 0));
    const std::size_t bytes = error ? 8 : std::strlen(hex) / 2;
    frame.insert(frame.end(), {static_cast<std::uint8_t>(bytes), 0, 0, 0});
    for (std::size_t i = 0; i < 8; ++i) {
      unsigned value = 0;
      if (2 * i + 1 < std::strlen(hex)) std::sscanf(hex + 2 * i, "%2x", &value);
      frame.push_back(static_cast<std::uint8_t>(value));
    }
    if (stamps_) add_u32(frame, clock_us());
    queue_.push_back(frame);
  }

 private:
  // 32 bits of microseconds, 100 ppm fast against the host.
  [[nodiscard]] std::uint32_t clock_us() const {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    const std::int64_t us = static_cast<std::int64_t>(now.tv_sec) * 1000000 + now.tv_nsec / 1000;
    return static_cast<std::uint32_t>(us + us / 10000) + clock_jump_us_;
  }

  bool started_ = false;
  bool stamps_ = false;
  std::uint32_t clock_jump_us_ = 0;
  std::deque<Bytes> queue_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: gs_usb_device PIPE\n", stderr);
    return 2;
  }
  CanAdapter adapter;
  return plug_in(adapter, argv[1]);
}
