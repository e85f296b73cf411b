// EVT decoders: format, cut and room come from the first three bytes, the stream is the rest.
#include <vector>

#include "fuzz/fuzz_input.hpp"
#include "hal/evt_decoder.hpp"

using namespace egofocus;

namespace {

constexpr SensorSize kSize{640, 480};

std::vector<Event> decode(EvtDecoder& decoder, std::span<const std::byte> bytes, std::size_t room,
                          std::size_t cut) {
  std::vector<Event> events;
  std::vector<Event> out(room);
  for (;;) {
    const std::span<const std::byte> piece = bytes.first(cut < bytes.size() ? cut : bytes.size());
    const Decoded done = decoder.feed(piece, out);
    fuzz::require(done.consumed <= piece.size() && done.produced <= room);
    fuzz::require(done.produced == room || done.consumed == piece.size());
    events.insert(events.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(done.produced));
    bytes = bytes.subspan(done.consumed);
    if (bytes.empty() && done.produced < room) return events;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  const auto format = static_cast<EvtFormat>(fuzz::take_byte(bytes) % 4);
  const std::size_t cut = std::size_t{1} + fuzz::take_byte(bytes);
  const std::size_t room = std::size_t{1} + fuzz::take_byte(bytes);

  EvtDecoder whole(format, kSize);
  const std::vector<Event> events = decode(whole, bytes, 4096, SIZE_MAX);
  for (const Event& event : events) {
    fuzz::require(event.x < kSize.width_px && event.y < kSize.height_px && event.polarity <= 1);
  }
  fuzz::require(whole.counters().events == events.size());

  EvtDecoder pieces(format, kSize);
  const std::vector<Event> again = decode(pieces, bytes, room, cut);
  fuzz::require(again.size() == events.size());
  for (std::size_t i = 0; i < events.size(); ++i) fuzz::require(fuzz::same(events[i], again[i]));
  fuzz::require(pieces.counters().violations == whole.counters().violations);
  fuzz::require(pieces.counters().dropped_events == whole.counters().dropped_events);
  return 0;
}
