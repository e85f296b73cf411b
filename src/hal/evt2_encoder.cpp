#include "hal/evt2_encoder.hpp"

#include <cstdint>

#include "hal/evt_words.hpp"

namespace egofocus {
namespace {

constexpr std::uint32_t kTimeHigh = 0x8u << 28;

}  // namespace

Decoded Evt2Encoder::encode(std::span<const Event> events, std::span<std::byte> out) noexcept {
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
      write_word(kTimeHigh | counter, out, done.produced);
      continue;
    }
    const std::uint32_t type = event.polarity != 0 ? 1 : 0;
    const std::uint32_t time_low = static_cast<std::uint32_t>(event.t_us & 0x3f);
    const std::uint32_t x = event.x;
    const std::uint32_t y = event.y;
    write_word(type << 28 | time_low << 22 | x << 11 | y, out, done.produced);
    ++counters_.events;
    ++done.consumed;
  }
  return done;
}

}  // namespace egofocus
