// Event text: cut and room come from the first two bytes, the text is the rest.
#include <vector>

#include "fuzz/fuzz_input.hpp"
#include "hal/event_text_decoder.hpp"

using namespace egofocus;

namespace {

constexpr SensorSize kSize{346, 260};

std::vector<Event> decode(EventTextDecoder& decoder, std::span<const std::byte> text, std::size_t room,
                          std::size_t cut) {
  std::vector<Event> events;
  std::vector<Event> out(room);
  std::size_t seen = 0;
  std::size_t taken = 0;
  while (taken < text.size()) {
    const bool last = seen == text.size();
    const std::span<const std::byte> piece = text.subspan(taken, seen - taken);
    const Decoded done = last ? decoder.finish(piece, out) : decoder.feed(piece, out);
    fuzz::require(done.consumed <= piece.size() && done.produced <= room);
    fuzz::require(!last || done.consumed > 0);
    events.insert(events.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(done.produced));
    taken += done.consumed;
    if (done.consumed == 0) seen = cut < text.size() - seen ? seen + cut : text.size();
  }
  return events;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::byte> text = std::as_bytes(std::span(data, size));
  const std::size_t cut = std::size_t{1} + fuzz::take_byte(text);
  const std::size_t room = std::size_t{1} + fuzz::take_byte(text) % 8;

  EventTextDecoder whole(kSize);
  const std::vector<Event> events = decode(whole, text, 4096, SIZE_MAX);
  for (const Event& event : events) {
    fuzz::require(event.x < kSize.width_px && event.y < kSize.height_px && event.polarity <= 1);
  }
  const EventTextCounters& n = whole.counters();
  fuzz::require(n.lines == n.events + n.blank + n.malformed + n.out_of_range + n.over_long);
  fuzz::require(n.events == events.size());

  EventTextDecoder pieces(kSize);
  const std::vector<Event> again = decode(pieces, text, room, cut);
  fuzz::require(again.size() == events.size());
  for (std::size_t i = 0; i < events.size(); ++i) fuzz::require(fuzz::same(events[i], again[i]));
  fuzz::require(pieces.counters().lines == n.lines);
  return 0;
}
