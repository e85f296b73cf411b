#include "recording/event_reader.hpp"

#include <algorithm>

namespace egofocus::recording {
namespace {

constexpr std::size_t kBatch = 4096;

}  // namespace

EventReader::EventReader(std::span<const std::byte> events_raw, const RawHeader& header)
    : decoder_(header.format, header.size), left_(events_raw.subspan(header.header_bytes)) {}

std::span<const Event> EventReader::between(std::int64_t first_us, std::int64_t last_us) {
  const auto after = [](std::int64_t t_us, const Event& event) { return t_us < event.t_us; };
  events_.erase(events_.begin(), std::upper_bound(events_.begin(), events_.end(), first_us, after));
  std::vector<Event> batch(kBatch);
  while (events_.empty() || events_.back().t_us <= last_us) {
    const Decoded done = decoder_.feed(left_, batch);
    if (done.produced == 0) break;
    left_ = left_.subspan(done.consumed);
    events_.insert(events_.end(), batch.begin(), batch.begin() + static_cast<std::ptrdiff_t>(done.produced));
  }
  const auto begin = std::upper_bound(events_.begin(), events_.end(), first_us, after);
  return {begin, std::upper_bound(begin, events_.end(), last_us, after)};
}

}  // namespace egofocus::recording
