#include "hal/evt3_encoder.hpp"

#include "hal/event_run.hpp"
#include "hal/evt_words.hpp"

namespace egofocus {
namespace {

constexpr std::uint16_t word_of(std::uint32_t type, std::uint32_t payload) noexcept {
  return static_cast<std::uint16_t>(type << 12 | payload);
}

constexpr std::uint32_t kAddrY = 0x0;
constexpr std::uint32_t kAddrX = 0x2;
constexpr std::uint32_t kVectBaseX = 0x3;
constexpr std::uint32_t kVect12 = 0x4;
constexpr std::uint32_t kVect8 = 0x5;
constexpr std::uint32_t kTimeLow = 0x6;
constexpr std::uint32_t kTimeHigh = 0x8;

// A base and the vectors of 12, 12 and 8 pixels after it, without the empty ones at the end.
std::size_t vector_words(std::uint32_t mask) noexcept {
  return mask >> 24 != 0 ? 4 : mask >> 12 != 0 ? 3 : 2;
}

}  // namespace

Decoded Evt3Encoder::encode(std::span<const Event> events, std::span<std::byte> out) noexcept {
  Decoded done;
  while (done.consumed < events.size() && out.size() - done.produced >= kMinRoomBytes) {
    const Event& event = events[done.consumed];
    if (event.x > 0x7ff || event.y > 0x7ff || !time_high_.can_reach(event.t_us >> 12)) {
      ++counters_.not_encodable;
      ++done.consumed;
      continue;
    }
    std::uint16_t word = 0;
    if (owes(event, word)) {
      write_word(word, out, done.produced);
      continue;
    }
    const std::uint32_t column = event.x | (event.polarity != 0 ? 1u << 11 : 0u);
    const EventRun run = run_from(events.subspan(done.consumed), event.x);
    const std::size_t words = vector_words(run.mask);
    if (words < run.events) {
      write_word(word_of(kVectBaseX, column), out, done.produced);
      write_word(word_of(kVect12, run.mask & 0xfff), out, done.produced);
      if (words > 2) write_word(word_of(kVect12, run.mask >> 12 & 0xfff), out, done.produced);
      if (words > 3) write_word(word_of(kVect8, run.mask >> 24), out, done.produced);
      counters_.events += run.events;
      done.consumed += run.events;
    } else {
      write_word(word_of(kAddrX, column), out, done.produced);
      ++counters_.events;
      ++done.consumed;
    }
  }
  return done;
}

// True: `word` brings the state nearer to the time and row of `event`; write it and ask again.
bool Evt3Encoder::owes(const Event& event, std::uint16_t& word) noexcept {
  std::uint32_t counter = 0;
  if (time_high_.owes(event.t_us >> 12, counter)) {
    word = word_of(kTimeHigh, counter);
    time_low_ = -1;
    return true;
  }
  const std::int32_t low = static_cast<std::int32_t>(event.t_us & 0xfff);
  if (low != time_low_) {
    word = word_of(kTimeLow, static_cast<std::uint32_t>(low));
    time_low_ = low;
    return true;
  }
  if (event.y != y_) {
    word = word_of(kAddrY, event.y);
    y_ = event.y;
    return true;
  }
  return false;
}

}  // namespace egofocus
