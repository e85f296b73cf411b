#include "hal/evt2_decoder.hpp"

namespace egofocus {
namespace {

enum Type : std::uint32_t {
  kCdOff = 0x0,
  kCdOn = 0x1,
  kTimeHigh = 0x8,
  kTrigger = 0xA,
  kImu = 0xD,
  kOther = 0xE,
  kContinued = 0xF,
};

constexpr std::uint32_t kContinuedPayload = 0x3fffff;  // the 22 bits that the rate counters use

}  // namespace

Decoded Evt2Decoder::feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept {
  Decoded done;
  std::uint32_t word = 0;
  while (done.produced < out.size() && words_.next(bytes, done.consumed, word)) {
    done.produced += take(word, out.subspan(done.produced));
  }
  return done;
}

std::size_t Evt2Decoder::take(std::uint32_t word, std::span<Event> room) noexcept {
  const std::uint32_t type = word >> 28;
  const bool is_event = type == kCdOff || type == kCdOn;
  if (type == kTimeHigh) {
    if (time_high_.take(word & 0xfffffff, counters_)) time_low_ = 0;
    return 0;
  }
  if (!time_high_.known()) {
    if (is_event) counters_.count(EvtViolation::kBeforeTimeHigh, 1);
    return 0;
  }
  if (is_event || type == kTrigger) time_low_ = (word >> 22) & 0x3f;
  const std::int64_t t_us = time_us();
  if (is_event) {
    const Event event{.t_us = t_us,
                      .x = static_cast<std::uint16_t>((word >> 11) & 0x7ff),
                      .y = static_cast<std::uint16_t>(word & 0x7ff),
                      .polarity = static_cast<std::uint8_t>(type)};
    return row_.place(event, 1, room, counters_);
  }
  switch (type) {
    case kTrigger:
      ++counters_.triggers;
      trigger_ = {.t_us = t_us,
                  .id = static_cast<std::uint8_t>((word >> 8) & 0x1f),
                  .value = static_cast<std::uint8_t>(word & 1)};
      break;
    case kImu:
      others_subtype_ = 0;
      break;  // old evaluation kits; its five CONTINUED words are passed over
    case kOther:
      others_subtype_ = word & 0xffff;
      break;
    case kContinued:
      counters_.take_others(others_subtype_, word & kContinuedPayload);
      others_subtype_ = 0;
      break;
    default:
      counters_.count(EvtViolation::kUnknownWord);
  }
  return 0;
}

}  // namespace egofocus
