#include "hal/evt21_decoder.hpp"

#include <bit>

namespace egofocus {
namespace {

enum Type : std::uint32_t {
  kNegative = 0x0,
  kPositive = 0x1,
  kTimeHigh = 0x8,
  kTrigger = 0xA,
  kOthers = 0xE,
  kContinued = 0xF,
};

}  // namespace

Decoded Evt21Decoder::feed(std::span<const std::byte> bytes, std::span<Event> out) noexcept {
  Decoded done;
  done.produced = row_.resume(out);
  std::uint64_t word = 0;
  while (done.produced < out.size() && words_.next(bytes, done.consumed, word)) {
    if (order_ == Evt21Order::kLegacy) word = word << 32 | word >> 32;
    done.produced += take(word, out.subspan(done.produced));
  }
  return done;
}

std::size_t Evt21Decoder::take(std::uint64_t word, std::span<Event> room) noexcept {
  const std::uint32_t upper = static_cast<std::uint32_t>(word >> 32);  // laid out much like an EVT 2.0 word
  const std::uint32_t lower = static_cast<std::uint32_t>(word);        // mask of pixels, or payload
  const std::uint32_t type = upper >> 28;
  const bool is_event = type == kNegative || type == kPositive;
  if (type == kTimeHigh) {
    if (time_high_.take(upper & 0xfffffff, counters_)) time_low_ = 0;
    return 0;
  }
  if (!time_high_.known()) {
    if (is_event)
      counters_.count(EvtViolation::kBeforeTimeHigh, static_cast<std::uint64_t>(std::popcount(lower)));
    return 0;
  }
  if (is_event || type == kTrigger) time_low_ = (upper >> 22) & 0x3f;
  const std::int64_t t_us = time_us();
  if (is_event) {
    const Event first{.t_us = t_us,
                      .x = static_cast<std::uint16_t>((upper >> 11) & 0x7ff),
                      .y = static_cast<std::uint16_t>(upper & 0x7ff),
                      .polarity = static_cast<std::uint8_t>(type)};
    return row_.place(first, lower, room, counters_);
  }
  switch (type) {
    case kTrigger:
      ++counters_.triggers;
      trigger_ = {.t_us = t_us,
                  .id = static_cast<std::uint8_t>((upper >> 8) & 0x1f),
                  .value = static_cast<std::uint8_t>(upper & 1)};
      break;
    case kOthers:
      counters_.take_others(upper & 0xffff, lower);
      break;
    case kContinued:
      break;  // more payload of an OTHERS that we have no use for
    default:
      counters_.count(EvtViolation::kUnknownWord);
  }
  return 0;
}

}  // namespace egofocus
