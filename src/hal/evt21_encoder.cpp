#include "hal/evt21_encoder.hpp"

#include <cstdint>

#include "hal/event_run.hpp"
#include "hal/evt_words.hpp"

namespace egofocus {
namespace {

constexpr std::uint32_t kTimeHigh = 0x8u << 28;

std::uint64_t word_of(std::uint32_t upper, std::uint32_t lower, Evt21Order order) noexcept {
  const bool swapped = order == Evt21Order::kLegacy;
  return static_cast<std::uint64_t>(swapped ? lower : upper) << 32 | (swapped ? upper : lower);
}

}  // namespace

Decoded Evt21Encoder::encode(std::span<const Event> events, std::span<std::byte> out) noexcept {
  Decoded done;
  while (done.consumed < events.size() && out.size() - done.produced >= kMinRoomBytes) {
    const Event& event = events[done.consumed];
    if (event.x > 0x7ff || event.y > 0x7ff || !time_high_.can_reach(event.t_us >> 6)) {
      ++counters_.not_encodable;
      ++done.consumed;
      continue;
    }
    std::uint32_t counter = 0;
    if (time_high_.owes(event.t_us >> 6, counter)) {
      write_word(word_of(kTimeHigh | counter, 0, order_), out, done.produced);
      continue;
    }
    const std::uint32_t type = event.polarity != 0 ? 1 : 0;
    const std::uint32_t time_low = static_cast<std::uint32_t>(event.t_us & 0x3f);
    const std::uint32_t first_x = event.x & ~31u;  // the format asks for multiples of 32
    const std::uint32_t y = event.y;
    const EventRun run = run_from(events.subspan(done.consumed), first_x);
    write_word(word_of(type << 28 | time_low << 22 | first_x << 11 | y, run.mask, order_), out,
               done.produced);
    counters_.events += run.events;
    done.consumed += run.events;
  }
  return done;
}

}  // namespace egofocus
