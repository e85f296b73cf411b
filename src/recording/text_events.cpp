#include "recording/text_events.hpp"

#include "hal/event_text_decoder.hpp"

namespace egofocus::recording {
namespace {

constexpr std::size_t kBlockEvents = 65536;
// Which sensor it was is not known yet.
constexpr SensorSize kAnySensor{65535, 65535};

}  // namespace

TextEvents parse_text_events(std::string_view text,
                             const std::function<void(std::size_t, std::size_t)>& progress) {
  TextEvents result;
  EventTextDecoder decoder(kAnySensor);
  std::span<const std::byte> rest = std::as_bytes(std::span(text.data(), text.size()));
  std::vector<Event> block(kBlockEvents);
  while (!rest.empty()) {
    const Decoded step = decoder.finish(rest, block);
    if (step.consumed == 0) break;
    rest = rest.subspan(step.consumed);
    for (std::size_t i = 0; i < step.produced; ++i) {
      if (!result.events.empty() && block[i].t_us < result.events.back().t_us) {
        ++result.out_of_order;
      } else {
        result.events.push_back(block[i]);
      }
    }
    if (progress) progress(text.size() - rest.size(), text.size());
  }
  const EventTextCounters& counters = decoder.counters();
  result.lines = counters.lines;
  result.blank = counters.blank;
  result.malformed = counters.malformed + counters.out_of_range + counters.over_long;
  return result;
}

}  // namespace egofocus::recording
