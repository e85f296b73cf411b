#include "hal/inivation_decoder.hpp"

#include <bit>

namespace egofocus {
namespace {

constexpr std::uint16_t kTimeStamp = 0x8000;
constexpr std::uint32_t kGroupRows = 8;

enum Code : std::uint32_t { kSpecial = 0, kMisc8 = 5, kMisc10 = 6, kWrap = 7 };
enum DavisCode : std::uint32_t { kRow = 1, kColumnOff = 2, kColumnOn = 3, kFrameSample = 4 };
enum DvxplorerCode : std::uint32_t { kColumn = 1, kSecondGroup = 2, kFirstGroup = 3, kRowGroups = 4 };

enum Special : std::uint16_t {
  kReserved = 0,
  kTimeReset = 1,
  kInputFalling = 2,
  kInputPulse = 4,
  kImuBegin = 5,
  kImuEnd = 7,
  kFrameFirst = 8,  // up to 15: begin, end and columns of frames, exposure
  kFrameLast = 15,
  kGeneratorRising = 17,
};

enum Misc8 : std::uint32_t { kImuByte = 0, kRegionHigh = 1, kRegionLow = 2, kImuConfiguration = 3 };

}  // namespace

InivationDecoded InivationDecoder::feed(std::span<const std::byte> bytes, std::span<Event> events,
                                        std::span<ImuSample> imu) noexcept {
  InivationDecoded done;
  done.events = resume(events);
  std::uint16_t word = 0;
  while (done.events < events.size() && done.imu < imu.size() && words_.next(bytes, done.consumed, word)) {
    bool has_sample = false;
    done.events += take(word, events.subspan(done.events), imu[done.imu], has_sample);
    done.imu += has_sample;
  }
  return done;
}

void InivationDecoder::end_transfer() noexcept {
  if (words_.drop_partial() > 0) counters_.count(InivationViolation::kOddByte);
}

std::size_t InivationDecoder::take(std::uint16_t word, std::span<Event> events, ImuSample& sample,
                                   bool& has_sample) noexcept {
  if ((word & kTimeStamp) != 0) {
    time_.stamp(word & 0x7fff, counters_);
    return 0;
  }
  const std::uint32_t code = word >> 12;
  const std::uint16_t data = word & 0xfff;
  switch (code) {
    case kSpecial:
      take_special(data, sample, has_sample);
      return 0;
    case kMisc8:
      take_misc8(data);
      return 0;
    case kMisc10:
      ++counters_.frame_words;  // exposure
      return 0;
    case kWrap:
      time_.wrap(data, counters_);
      return 0;
    default:
      return layout_.format == InivationFormat::kDavis ? take_davis(code, data, events)
                                                       : take_dvxplorer(code, data, events);
  }
}

void InivationDecoder::take_special(std::uint16_t data, ImuSample& sample, bool& has_sample) noexcept {
  if (data == kReserved || (data > kFrameLast && data <= kGeneratorRising)) return;
  if (data == kTimeReset) {
    time_.reset();
    ++counters_.time_resets;
  } else if (data >= kInputFalling && data <= kInputPulse) {
    ++counters_.triggers;
  } else if (data == kImuBegin) {
    imu_.begin();
  } else if (data == kImuEnd) {
    has_sample = imu_.end(time_.us(), sample, counters_);
  } else if (data >= kFrameFirst && data <= kFrameLast) {
    ++counters_.frame_words;
  } else {
    counters_.count(InivationViolation::kUnknownWord);
  }
}

void InivationDecoder::take_misc8(std::uint16_t data) noexcept {
  const auto value = static_cast<std::uint8_t>(data & 0xff);
  switch (data >> 8) {
    case kImuByte:
      imu_.add(value);
      break;
    case kImuConfiguration:
      imu_.configure(value);
      break;
    case kRegionHigh:
    case kRegionLow:
      ++counters_.frame_words;
      break;
    default:
      counters_.count(InivationViolation::kUnknownWord);
  }
}

std::size_t InivationDecoder::take_davis(std::uint32_t code, std::uint16_t data,
                                         std::span<Event> room) noexcept {
  switch (code) {
    case kRow:
      y_ = data;
      return 0;
    case kColumnOff:
    case kColumnOn:
      return place(data, y_, 1, code == kColumnOn ? 1 : 0, room);
    default:  // the one code that is left
      static_assert(kFrameSample == 4);
      ++counters_.frame_words;
      return 0;
  }
}

std::size_t InivationDecoder::take_dvxplorer(std::uint32_t code, std::uint16_t data,
                                             std::span<Event> room) noexcept {
  switch (code) {
    case kColumn:
      x_ = data & 0x3ff;
      return 0;
    case kRowGroups:
      take_row_groups(data);
      return 0;
    default: {
      const std::uint16_t y = code == kFirstGroup ? y_ : second_y_;
      return place(x_, y, data & 0xff, (data & 0x100) == 0 ? 1 : 0, room);
    }
  }
}

// The second group is told by its distance from the first. A difference below zero becomes a row that no
// sensor has.
void InivationDecoder::take_row_groups(std::uint16_t data) noexcept {
  const std::uint32_t first = data & 0x3f;
  const std::uint32_t distance = (data >> 6) & 0x1f;
  const std::uint32_t second = (data & 0x800) != 0 ? first - distance : first + distance;
  y_ = static_cast<std::uint16_t>(first * kGroupRows);
  second_y_ = second > 0x7f ? kNowhere : static_cast<std::uint16_t>(second * kGroupRows);
}

std::size_t InivationDecoder::place(std::uint16_t x, std::uint16_t y, std::uint32_t mask,
                                    std::uint8_t polarity, std::span<Event> room) noexcept {
  if (!time_.is_good()) {
    const auto lost = static_cast<std::uint64_t>(std::popcount(mask));
    if (time_.is_known()) {
      counters_.dropped_events += lost;  // the step back is counted already
    } else if (lost > 0) {
      counters_.count(InivationViolation::kBeforeTime, lost);
    }
    return 0;
  }
  const bool is_inside = x < layout_.sent.width_px && y < layout_.sent.height_px;
  const int rows = is_inside ? layout_.sent.height_px - y : 0;
  const std::uint32_t inside = rows >= 8 ? mask : mask & ((1u << rows) - 1);
  if (inside != mask) {
    counters_.count(InivationViolation::kOutOfRange,
                    static_cast<std::uint64_t>(std::popcount(mask ^ inside)));
  }
  counters_.events += static_cast<std::uint64_t>(std::popcount(inside));
  held_ = {.t_us = time_.us(), .x = x, .y = y, .polarity = polarity};
  held_mask_ = inside;
  return resume(room);
}

std::size_t InivationDecoder::resume(std::span<Event> room) noexcept {
  std::size_t written = 0;
  for (; held_mask_ != 0 && written < room.size(); held_mask_ &= held_mask_ - 1) {
    Event event = held_;
    event.y = static_cast<std::uint16_t>(event.y + std::countr_zero(held_mask_));
    if (layout_.swaps_xy) {
      const std::uint16_t x = event.x;
      event.x = event.y;
      event.y = x;
    }
    room[written++] = event;
  }
  return written;
}

}  // namespace egofocus
