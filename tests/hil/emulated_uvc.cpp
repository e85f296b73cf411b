#include "hil/emulated_uvc.hpp"

#include <algorithm>
#include <cerrno>

#include "hil/evt3_words.hpp"

namespace egofocus::hil {
namespace {

constexpr std::uint32_t kWidth = 1024, kHeight = 32;  // of the frame, which is a packet: no pixels
constexpr std::uint32_t kFrameBytes = kWidth * kHeight;
constexpr std::uint32_t kInterval_100ns = 100'000;
constexpr std::int64_t kFrame_us = 10'000;
constexpr std::size_t kHeaderBytes = 2;
constexpr std::uint8_t kProbe = 1, kCommit = 2;  // selectors
constexpr std::uint8_t kSetCurrent = 0x01, kGetCurrent = 0x81, kGetLeast = 0x82, kGetMost = 0x83,
                       kGetLength = 0x85, kGetInformation = 0x86, kGetDefault = 0x87;

void add(Bytes& bytes, std::initializer_list<std::uint8_t> more) {
  for (const std::uint8_t byte : more) bytes.push_back(byte);
}

Bytes configuration() {
  Bytes all = {9, 2, 0, 0, 2, 1, 0, 0x80, 50, 8, 11, 0, 2, 14, 3, 0, 0};  // two interfaces, one function
  add(all, {9, 4, 0, 0, 0, 14, 1, 0, 0});                                 // video control
  add(all, {13, 0x24, 1, 0, 1, 13 + 18 + 9, 0, 0x40, 0x42, 0x0f, 0, 1, 1});
  add(all, {18, 0x24, 2, 1, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0});  // a camera
  add(all, {9, 0x24, 3, 2, 1, 1, 0, 1, 0});                              // its way out
  add(all, {9, 4, 1, 0, 1, 14, 2, 0, 0});                                // video streaming
  add(all, {14, 0x24, 1, 1, 14 + 27 + 30, 0, 0x81, 0, 2, 0, 0, 0, 1, 0});
  add(all, {27, 0x24, 4,    1, 1,    'Y',  '8',  ' ', ' ', 0, 0, 0x10, 0, 0x80,
            0,  0,    0xaa, 0, 0x38, 0x9b, 0x71, 8,   1,   0, 0, 0,    0});
  add(all, {30, 0x24, 5, 1, 0});
  add_u16(all, kWidth);
  add_u16(all, kHeight);
  for (int i = 0; i < 2; ++i) add_u32(all, kFrameBytes * 8 * 100);  // bit/s
  add_u32(all, kFrameBytes);
  add_u32(all, kInterval_100ns);
  add(all, {1});
  add_u32(all, kInterval_100ns);
  add(all, {7, 5, 0x81, 2, 0, 2, 0});
  return all;
}

// The one stream there is, whatever was proposed.
Bytes stream_parameters() {
  Bytes all = {0, 0, 1, 1};
  add_u32(all, kInterval_100ns);
  all.resize(all.size() + 10);
  add_u32(all, kFrameBytes);
  add_u32(all, kFrameBytes + kHeaderBytes);
  return all;
}

}  // namespace

EmulatedUvc::EmulatedUvc(EventFeed& feed)
    : EmulatedUsb({.vendor = 0x1209,
                   .product = 0x0002,
                   .release = 1,
                   .device_class = {0xef, 2, 1},
                   .texts = {"egofocus tests", "event sensor", "1"}},
                  configuration()),
      feed_(feed),
      stale_(kFrameBytes, 0xff) {}

bool EmulatedUvc::control(const Setup& setup, Bytes& data) {
  const auto selector = static_cast<std::uint8_t>(setup.value >> 8);
  if ((setup.index & 0xff) != 1 || (selector != kProbe && selector != kCommit)) return false;
  switch (setup.request) {
    case kSetCurrent:
      if (selector == kProbe) return true;
      payload_.clear();
      at_ = 0;
      feed_.restart();
      time_.begin();
      return true;
    case kGetCurrent:
    case kGetLeast:
    case kGetMost:
    case kGetDefault:
      data = stream_parameters();
      return true;
    case kGetLength:
      data = {static_cast<std::uint8_t>(stream_parameters().size()), 0};
      return true;
    case kGetInformation:
      data = {3};
      return true;
    default:
      return false;
  }
}

void EmulatedUvc::make_frame(std::int64_t until_us) {
  frame_id_ ^= 1;
  Bytes words;
  add_evt3(feed_, time_, until_us, kFrameBytes - 8, words);
  for (int i = 0; i < 4; ++i) add_u16(words, 0xE019);
  std::copy(words.begin(), words.end(), stale_.begin());
  payload_ = {kHeaderBytes, static_cast<std::uint8_t>(0x82 | frame_id_)};  // end of header, end of frame
  payload_.insert(payload_.end(), stale_.begin(), stale_.end());
  at_ = 0;
}

int EmulatedUvc::in(std::uint8_t, std::size_t most, Bytes& data) {
  if (!time_.runs()) return EAGAIN;
  if (at_ == payload_.size()) {
    const std::int64_t until_us = time_.now_us();
    if (until_us - time_.sent_us() < kFrame_us) return EAGAIN;
    make_frame(until_us);
  }
  const std::size_t bytes = std::min(most, payload_.size() - at_);
  const auto from = payload_.begin() + static_cast<long>(at_);
  data.assign(from, from + static_cast<long>(bytes));
  at_ += bytes;
  return 0;
}

}  // namespace egofocus::hil
