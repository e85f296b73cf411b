#include "hil/emulated_davis.hpp"

#include <algorithm>
#include <cerrno>

namespace egofocus::hil {
namespace {

constexpr std::uint32_t at(std::uint32_t module, std::uint32_t parameter) {
  return module << 16 | parameter;
}
constexpr std::uint32_t kMuxRun = at(0, 0);
constexpr std::uint32_t kTimeRun = at(0, 1);
constexpr std::uint32_t kTimeReset = at(0, 2);
constexpr std::uint32_t kDvsRun = at(1, 3);
constexpr std::uint32_t kGyroRun = at(3, 3);
constexpr std::uint32_t kUsbRun = at(9, 0);
constexpr std::int64_t kPacket_us = 1000;
constexpr std::int64_t kWrap_us = 0x8000;
constexpr std::size_t kLongestSample = 64;  // bytes of an IMU sample, or of an event, with their time words

std::uint32_t big_endian(const Bytes& bytes, std::size_t first) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | bytes[first + i];
  return value;
}

Bytes configuration() {
  return {9, 2, 0,    0, 1,    1,    0, 0x80, 250,  // configuration 1, one interface
          9, 4, 0,    0, 1,    0xff, 0, 0,    0,    // interface 0, one endpoint
          7, 5, 0x82, 2, 0x00, 0x02, 0};            // bulk IN, 512 bytes
}

}  // namespace

EmulatedDavis::EmulatedDavis(EventFeed& feed)
    : EmulatedUsb({.vendor = 0x152a,
                   .product = 0x841a,
                   .release = 6,
                   .device_class = {0xff, 0, 0},
                   .texts = {"iniVation", "DAVIS346", "00000346"}},
                  configuration()),
      feed_(feed),
      parameters_{{at(6, 0), 18},   {at(6, 1), 5},         {at(6, 2), 1},          {at(6, 5), 80},
                  {at(6, 6), 1000}, {at(6, 7), 1},         {at(0, 80), 1},         {at(0, 83), 0},
                  {at(0, 84), 0},   {at(1, 0), kWidth_px}, {at(1, 1), kHeight_px}, {at(1, 2), 0},
                  {at(1, 10), 1},   {at(1, 30), 1},        {at(3, 1), 0}} {}

void EmulatedDavis::set_logic_version(std::uint32_t version) {
  const std::lock_guard lock(mutex_);
  parameters_[at(6, 0)] = version;
}

void EmulatedDavis::set_dropped(std::uint64_t events) {
  const std::lock_guard lock(mutex_);
  parameters_[at(0, 83)] = static_cast<std::uint32_t>(events >> 32);
  parameters_[at(0, 84)] = static_cast<std::uint32_t>(events);
}

bool EmulatedDavis::control(const Setup& setup, Bytes& data) {
  const std::lock_guard lock(mutex_);
  const std::uint32_t address = at(setup.value, setup.index);
  if (setup.type == 0x40 && setup.request == 0xBF && data.size() == 4) {
    write(address, big_endian(data, 0));
    return true;
  }
  if (setup.type == 0x40 && setup.request == 0xC2 && data.size() == setup.value * 6u) {
    for (std::size_t i = 0; i < data.size(); i += 6) write(at(data[i], data[i + 1]), big_endian(data, i + 2));
    return true;
  }
  if (setup.type != 0xC0 || setup.request != 0xBF) return false;
  const std::uint32_t value = parameters_[address];
  data = {static_cast<std::uint8_t>(value >> 24), static_cast<std::uint8_t>(value >> 16),
          static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
  return true;
}

void EmulatedDavis::write(std::uint32_t address, std::uint32_t value) {
  const bool is_start = value == 1 && parameters_[address] == 0;
  parameters_[address] = value;
  if (address == kTimeReset && is_start) has_reset_ = true;
  if (address != kDvsRun) return;
  time_.end();
  if (!is_start) return;
  feed_.restart();
  wraps_sent_ = next_imu_us_ = 0;
  time_.begin();
}

bool EmulatedDavis::runs(std::uint32_t address) const {
  const auto found = parameters_.find(address);
  return found != parameters_.end() && found->second == 1;
}

void EmulatedDavis::halt_cleared(std::uint8_t) {
  is_halted_ = false;
}

int EmulatedDavis::in(std::uint8_t, std::size_t most, Bytes& data) {
  if (is_halted_) return EPIPE;
  const std::lock_guard lock(mutex_);
  if (is_held_ || !runs(kUsbRun) || !runs(kMuxRun) || !runs(kTimeRun) || !time_.runs()) return EAGAIN;
  const std::int64_t until_us = time_.now_us();
  if (until_us - time_.sent_us() < kPacket_us) return EAGAIN;
  make_stream(until_us, most, data);
  return 0;
}

void EmulatedDavis::put_time(std::int64_t t_us, Bytes& data) {
  const std::int64_t wraps = t_us / kWrap_us;
  if (wraps > wraps_sent_) {
    add_u16(data, 0x7000 + static_cast<std::uint32_t>(std::min<std::int64_t>(wraps - wraps_sent_, 0xfff)));
    wraps_sent_ = wraps;
  }
  add_u16(data, 0x8000 + static_cast<std::uint32_t>(t_us % kWrap_us));
}

void EmulatedDavis::make_stream(std::int64_t until_us, std::size_t most, Bytes& data) {
  if (has_reset_) add_u16(data, 0x0001);
  has_reset_ = false;
  const auto has_room = [&] { return data.size() + kLongestSample < most; };
  std::int64_t t_us = time_.sent_us();
  for (; feed_.next().t_us <= until_us && has_room(); feed_.take()) {
    const Event& event = feed_.next();
    t_us = event.t_us;
    put_time(t_us, data);
    add_u16(data, 0x1000u + event.y);
    add_u16(data, (event.polarity == 0 ? 0x2000u : 0x3000u) + event.x);
  }
  if (has_room()) {
    put_time(until_us, data);
    t_us = until_us;
  }
  time_.send(t_us);
  if (runs(kGyroRun) && t_us >= next_imu_us_ && has_room()) {
    add_u16(data, 0x0005);
    add_u16(data, 0x5300 + 0xE5);  // all parts, +-4 g, +-500 deg/s
    const std::uint8_t values[14] = {0x20, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x01, 0x48};
    for (const std::uint8_t value : values) add_u16(data, 0x5000u + value);
    add_u16(data, 0x0007);
    next_imu_us_ = t_us + 1000;
  }
}

}  // namespace egofocus::hil
