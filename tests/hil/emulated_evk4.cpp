#include "hil/emulated_evk4.hpp"

#include <algorithm>
#include <cerrno>
#include <string_view>

#include "hil/evt3_words.hpp"

namespace egofocus::hil {
namespace {

constexpr std::uint8_t kAnswers = 0x82;
constexpr std::uint32_t kSerial = 0x72, kRelease = 0x79, kDeviceCount = 0x10000, kCompatible = 0x10003;
constexpr std::uint32_t kRegisters = 0x10102, kWrite = 0x40000000, kFailure = 0x80000000;
constexpr std::uint32_t kReadOut = 0x0004, kReadOutRuns = 0x400;
constexpr std::size_t kHeader = 8;  // property, bytes of the payload
constexpr std::int64_t kPacket_us = 1000;
constexpr std::size_t kLongestPacket = 32768;

Bytes configuration() {
  return {9, 2, 0,    0, 1, 1,    0,    0x80, 250,  // one interface
          9, 4, 0,    0, 3, 0xff, 0x19, 0,    0,    // of the vendor's class, three endpoints
          7, 5, 0x82, 2, 0, 2,    0,    7,    5,   0x02, 2, 0, 2, 0, 7, 5, 0x81, 2, 0, 2, 0};
}

std::uint32_t word(const Bytes& bytes, std::size_t number) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4 && 4 * number + i < bytes.size(); ++i)
    value |= static_cast<std::uint32_t>(bytes[4 * number + i]) << 8 * i;
  return value;
}

}  // namespace

EmulatedEvk4::EmulatedEvk4(EventFeed& feed)
    : EmulatedUsb({.vendor = 0x04b4,
                   .product = 0x00f5,
                   .release = 0x0307,
                   .device_class = {},
                   .texts = {"Prophesee", "EVK4", "00000636"}},
                  configuration()),
      feed_(feed),
      registers_{{0x14, 0xA0401806}, {0xF128, 0}} {}

void EmulatedEvk4::out(std::uint8_t, const Bytes& data) {
  if (data.size() < kHeader) return;
  const std::uint32_t property = word(data, 0);
  Bytes payload;
  bool is_known = true;
  answer(property, Bytes(data.begin() + kHeader, data.end()), payload, is_known);
  Bytes frame;
  add_u32(frame, is_known ? property : property | kFailure);
  add_u32(frame, static_cast<std::uint32_t>(payload.size()));
  frame.insert(frame.end(), payload.begin(), payload.end());
  answers_.push_back(frame);
}

void EmulatedEvk4::answer(std::uint32_t property, const Bytes& request, Bytes& payload, bool& is_known) {
  constexpr std::string_view kNames("psee,ccam5_imx636\0psee,ccam5_gen42\0", 35);
  switch (property) {
    case kSerial:
      return add_u32(payload, 0x636);
    case kRelease:
      return add_u32(payload, 0x030902);
    case kDeviceCount:
      return add_u32(payload, 1);
    case kCompatible:
      add_u32(payload, 0);
      payload.insert(payload.end(), kNames.begin(), kNames.end());
      return;
    case kRegisters:
    case kRegisters | kWrite:
      for (std::size_t i = 0; i < 2; ++i) add_u32(payload, word(request, i));
      if (property != kRegisters) write(word(request, 1), word(request, 2));
      return add_u32(payload, registers_[word(request, 1)]);
    default:
      is_known = false;
  }
}

void EmulatedEvk4::write(std::uint32_t address, std::uint32_t value) {
  const bool ran = time_.runs();
  registers_[address] = value;
  const bool runs = (registers_[kReadOut] & kReadOutRuns) != 0;
  if (!runs) time_.end();
  if (!runs || ran) return;
  feed_.restart();
  time_.begin();
}

int EmulatedEvk4::in(std::uint8_t endpoint, std::size_t most, Bytes& data) {
  if (endpoint == kAnswers) {
    if (answers_.empty()) return EAGAIN;
    data = answers_.front();
    answers_.pop_front();
    return 0;
  }
  if (!time_.runs()) return EAGAIN;
  const std::int64_t until_us = time_.now_us();
  if (until_us - time_.sent_us() < kPacket_us) return EAGAIN;
  add_evt3(feed_, time_, until_us, std::min(most, kLongestPacket), data);
  return 0;
}

}  // namespace egofocus::hil
