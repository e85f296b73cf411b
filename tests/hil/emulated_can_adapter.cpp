#include "hil/emulated_can_adapter.hpp"

#include <cerrno>

#include "hil/camera_time.hpp"

namespace egofocus::hil {
namespace {

enum Request : std::uint8_t { kMode = 2, kBtConst = 4, kDeviceConfig = 5, kTimestamp = 6 };  // gs_usb_breq
constexpr std::uint32_t kListenOnly = 1, kLoopBack = 2, kOneShot = 8, kHardwareTime = 16;
constexpr std::uint32_t kFromBus = 0xffffffff;  // echo_id of a frame that this adapter did not send
constexpr std::uint32_t kErrorFrame = 0x20000000;
constexpr std::size_t kFrameBytes = 20;  // of struct gs_host_frame, without the stamp

Bytes configuration() {
  return {9, 2, 0,    0, 1, 1,    0,    0x80, 50,  // one interface
          9, 4, 0,    0, 2, 0xff, 0xff, 0xff, 0,   // of the vendor's class, two endpoints
          7, 5, 0x81, 2, 0, 2,    0,               // bulk in, 512 bytes
          7, 5, 0x02, 2, 0, 2,    0};              // bulk out
}

}  // namespace

EmulatedCanAdapter::EmulatedCanAdapter()
    : EmulatedUsb({.vendor = 0x1d50,
                   .product = 0x606f,
                   .release = 1,
                   .device_class = {},
                   .texts = {"egofocus tests", "gs_usb adapter", "1"}},
                  configuration()) {}

bool EmulatedCanAdapter::control(const Setup& setup, Bytes& data) {
  switch (setup.request) {
    case kMode: {
      const std::lock_guard lock(mutex_);
      if (data.size() >= 8) {
        is_started_ = data[0] == 1;
        has_stamps_ = (data[4] & kHardwareTime) != 0;
        queue_.clear();
      }
      return true;
    }
    case kBtConst:  // features, clock, then tseg1, tseg2, sjw, brp: least, most, step
      for (const std::uint32_t v : {kListenOnly | kLoopBack | kOneShot | kHardwareTime, 48000000u, 1u, 16u,
                                    1u, 8u, 4u, 1u, 1024u, 1u})
        add_u32(data, v);
      return true;
    case kDeviceConfig:
      for (const std::uint32_t v : {0u, 2u, 1u}) add_u32(data, v);  // one channel; versions
      return true;
    case kTimestamp:
      add_u32(data, clock_us());
      return true;
    default:
      return (setup.type & 0x80) == 0;  // host format, bit timing: taken
  }
}

// What the host sends is echoed as sent.
void EmulatedCanAdapter::out(std::uint8_t, const Bytes& data) {
  if (data.size() < kFrameBytes) return;
  const std::lock_guard lock(mutex_);
  Bytes echo(data.begin(), data.begin() + kFrameBytes);
  if (has_stamps_) add_u32(echo, clock_us());
  queue_.push_back(echo);
}

int EmulatedCanAdapter::in(std::uint8_t, std::size_t, Bytes& data) {
  const std::lock_guard lock(mutex_);
  if (queue_.empty() || !is_started_) return EAGAIN;
  data = queue_.front();
  queue_.pop_front();
  return 0;
}

void EmulatedCanAdapter::error(std::uint32_t classes, std::initializer_list<std::uint8_t> data) {
  Bytes all(data);
  all.resize(8);
  send(classes | kErrorFrame, all, clock_us());
}

void EmulatedCanAdapter::send(std::uint32_t id, std::span<const std::uint8_t> data, std::uint32_t stamp_us) {
  Bytes frame;
  add_u32(frame, kFromBus);
  add_u32(frame, id);
  frame.insert(frame.end(), {static_cast<std::uint8_t>(data.size()), 0, 0, 0});
  frame.insert(frame.end(), data.begin(), data.end());
  frame.resize(kFrameBytes);
  const std::lock_guard lock(mutex_);
  if (!is_started_) return;
  if (has_stamps_) add_u32(frame, stamp_us);
  queue_.push_back(frame);
}

// 32 bits of microseconds, 100 ppm fast against the host.
std::uint32_t EmulatedCanAdapter::clock_us() {
  const std::int64_t us = host_us();
  return static_cast<std::uint32_t>(us + us / 10000);
}

}  // namespace egofocus::hil
