#include "hal/evt3_decoder.hpp"

#include <bit>

namespace egofocus {
namespace {

enum Type : std::uint16_t {
  kAddrY = 0x0,
  kAddrX = 0x2,
  kVectBaseX = 0x3,
  kVect12 = 0x4,
  kVect8 = 0x5,
  kTimeLow = 0x6,
  kContinued4 = 0x7,
  kTimeHigh = 0x8,
  kTrigger = 0xA,
  kImu = 0xD,
  kOthers = 0xE,
  kContinued12 = 0xF,
};

constexpr std::uint16_t kPixelBits = 0x7ff;
constexpr int kPolarityShift = 11;
constexpr std::uint16_t kPastAllColumns = kPixelBits + 1;  // where a base that ran off the sensor stays

std::uint64_t events_in(std::uint32_t type, std::uint16_t word) noexcept {
  switch (type) {
    case kAddrX:
      return 1;
    case kVect12:
      return static_cast<std::uint64_t>(std::popcount(word & 0xfffu));
    case kVect8:
      return static_cast<std::uint64_t>(std::popcount(word & 0xffu));
    default:
      return 0;
  }
}

}  // namespace

Decoded Evt3Decoder::feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept {
  Decoded done;
  done.produced = row_.resume(out);
  std::uint16_t word = 0;
  while (done.produced < out.size() && words_.next(bytes, done.consumed, word)) {
    done.produced += take(word, out.subspan(done.produced));
  }
  return done;
}

std::size_t Evt3Decoder::take(std::uint16_t word, std::span<Event> room) noexcept {
  const std::uint32_t type = word >> 12;
  const std::uint16_t payload = word & 0xfff;
  if (!time_high_.known() && type != kTimeHigh) {
    const std::uint64_t lost = events_in(type, word);
    if (lost > 0) counters_.count(EvtViolation::kBeforeTimeHigh, lost);
    return 0;
  }
  const std::uint16_t pixel = word & kPixelBits;
  const std::uint8_t polarity = (word >> kPolarityShift) & 1;
  switch (type) {
    case kTimeHigh:
      // The words are redundant: only one that brings a new value starts the lower part afresh.
      if (time_high_.take(payload, counters_)) time_low_ = 0;
      break;
    case kTimeLow:
      take_time_low(payload);
      break;
    case kAddrY:  // the bit above y names the camera of a synchronised pair; there is one here
      y_ = pixel;
      has_y_ = true;
      break;
    case kAddrX:
      return place(pixel, polarity, 1, room);
    case kVectBaseX:
      base_x_ = pixel;
      base_polarity_ = polarity;
      has_base_ = true;
      break;
    case kVect12:
      return take_vector(payload, 12, room);
    case kVect8:
      return take_vector(payload & 0xff, 8, room);
    case kTrigger:
      ++counters_.triggers;
      trigger_ = {.t_us = time_us(),
                  .id = static_cast<std::uint8_t>(payload >> 8),
                  .value = static_cast<std::uint8_t>(payload & 1)};
      break;
    case kOthers:
      others_ = {.subtype = payload};
      break;
    case kContinued12:
    case kContinued4:
      take_others_part(type, payload);
      break;
    case kImu:
      others_ = {};
      break;
    default:
      counters_.count(EvtViolation::kUnknownWord);
  }
  return 0;
}

// The payload comes low bits first: 12, 12, then 4, which real sensors leave out where they are zero. The
// counters are sums, so each part can be added as soon as it is there.
void Evt3Decoder::take_others_part(std::uint32_t type, std::uint32_t payload) noexcept {
  const int shift = others_.next_shift;
  const bool expected = shift < 24 ? type == kContinued12 : shift == 24 && type == kContinued4;
  if (!expected) return;
  counters_.take_others(others_.subtype, (shift < 24 ? payload : payload & 0xf) << shift);
  others_.next_shift += 12;
}

void Evt3Decoder::take_time_low(std::uint16_t low) noexcept {
  if (low < time_low_) counters_.count(EvtViolation::kTimeLowBackward);
  time_low_ = low;
}

std::size_t Evt3Decoder::take_vector(std::uint32_t mask, int columns, std::span<Event> room) noexcept {
  if (!has_base_) {
    counters_.count(EvtViolation::kBeforeBase, static_cast<std::uint64_t>(std::popcount(mask)));
    return 0;
  }
  const std::uint16_t x = base_x_;
  base_x_ = static_cast<std::uint16_t>(x + columns < kPastAllColumns ? x + columns : kPastAllColumns);
  return place(x, base_polarity_, mask, room);
}

std::size_t Evt3Decoder::place(std::uint16_t x, std::uint8_t polarity, std::uint32_t mask,
                               std::span<Event> room) noexcept {
  if (!has_y_) {
    counters_.count(EvtViolation::kBeforeY, static_cast<std::uint64_t>(std::popcount(mask)));
    return 0;
  }
  return row_.place({.t_us = time_us(), .x = x, .y = y_, .polarity = polarity}, mask, room, counters_);
}

}  // namespace egofocus
