// Frames of a V4L2 event sensor: format from the first byte, the rest is a buffer that is cut at the
// end-of-frame marker and decoded, then decoded again after a loss.
#include <algorithm>
#include <vector>

#include "fuzz/fuzz_input.hpp"
#include "hal/evt_decoder.hpp"
#include "hal/evt_frame_end.hpp"

using namespace egofocus;

namespace {

constexpr SensorSize kSize{1280, 720};

// The rule once more, plainly, on whole words.
bool is_marker(EvtFormat format, std::span<const std::byte> word) {
  const auto at = [&](std::size_t i) { return std::to_integer<unsigned>(word[i]); };
  const std::size_t half = format == EvtFormat::kEvt21 ? 4 : 0;  // where the type lies
  switch (format) {
    case EvtFormat::kEvt3:
      return at(0) == 0x19 && at(1) == 0xE0;
    case EvtFormat::kEvt2:
      return at(0) == 0x19 && at(1) == 0xE0 && at(2) == 0x19 && at(3) == 0xE0;
    case EvtFormat::kEvt21:
    case EvtFormat::kEvt21Legacy:
      break;
  }
  return at(half) == 0x19 && at(half + 3) >= 0xE0;
}

std::vector<Event> decode(EvtDecoder& decoder, std::span<const std::byte> bytes) {
  std::vector<Event> events;
  std::vector<Event> out(64);
  for (bool more = true; more;) {
    const Decoded done = decoder.feed(bytes, out);
    bytes = bytes.subspan(done.consumed);
    events.insert(events.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(done.produced));
    more = done.produced == out.size();
  }
  fuzz::require(bytes.empty());
  return events;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  const auto format = static_cast<EvtFormat>(fuzz::take_byte(bytes) % 4);
  const std::size_t word = word_bytes(format);
  std::size_t expected = bytes.size();
  bool is_expected = false;
  for (std::size_t at = 0; at + word <= bytes.size() && !is_expected; at += word) {
    is_expected = is_marker(format, bytes.subspan(at, word));
    if (is_expected) expected = at;
  }

  const EvtFrameEnd end(format);
  std::vector<std::byte> copy(bytes.size());
  bool is_marked = false;
  const std::size_t valid = end.copy(bytes, copy, is_marked);
  fuzz::require(is_marked == is_expected && valid == expected);
  fuzz::require(std::equal(copy.begin(), copy.begin() + static_cast<std::ptrdiff_t>(valid), bytes.begin()));
  fuzz::require(end.find(bytes) == (is_expected ? expected : EvtFrameEnd::kNone));

  EvtDecoder decoder(format, kSize);
  const std::span<const std::byte> frame = std::span<const std::byte>(copy).first(valid);
  const std::vector<Event> events = decode(decoder, frame);
  fuzz::require(decoder.counters().events == events.size());

  // After a loss nothing comes before a TIME_HIGH that was accepted, and times go on where they were.
  decoder.resync();
  fuzz::require(!decoder.is_time_known());
  const std::uint64_t before = decoder.counters().events;
  const std::vector<Event> again = decode(decoder, frame);
  fuzz::require(decoder.counters().events - before == again.size());
  if (!decoder.is_time_known()) fuzz::require(again.empty());
  decoder.drop_partial();
  for (const Event& event : again) fuzz::require(event.x < kSize.width_px && event.y < kSize.height_px);
  return 0;
}
