#include "citysim/event_stream.hpp"

#include <algorithm>
#include <string>

#include "hal/evt_decoder.hpp"
#include "recording/error.hpp"
#include "recording/mapped_file.hpp"
#include "recording/text_events.hpp"

namespace egofocus::citysim {
namespace {

using recording::Error;
using recording::ExitCode;

constexpr SensorSize kKnownSensors[] = {{128, 128}, {240, 180}, {304, 240},  {320, 240},
                                        {346, 260}, {640, 480}, {1280, 720}, {2048, 2048}};
constexpr int kMostPixels = 2048 * 2048;  // a file may say anything
constexpr std::int64_t kLatest_us = std::int64_t{1} << 60;

/// Appends what can be used.
void take(std::span<const Event> events, EventStream& stream) {
  for (const Event& event : events) {
    const bool usable = event.t_us > -kLatest_us && event.t_us < kLatest_us &&
                        (stream.events.empty() || event.t_us >= stream.events.back().t_us);
    if (usable) {
      stream.events.push_back(event);
    } else {
      ++stream.dropped;
    }
  }
}

EventStream read_raw(std::span<const std::byte> file, const std::string& name) {
  RawHeader header;
  const Status status = parse_raw_header(file, header);
  if (!status.ok()) {
    char text[200];
    status.describe(text);
    throw Error(ExitCode::kBadFile, name, text);
  }
  EventStream stream;
  stream.size = header.size;
  if (header.size.width_px * header.size.height_px > kMostPixels)
    throw Error(ExitCode::kBadFile, name, "its header has a sensor of more than 2048 x 2048 pixels.");
  EvtDecoder decoder(header.format, header.size);
  std::span<const std::byte> rest = file.subspan(header.header_bytes);
  std::vector<Event> block(1u << 14);
  for (Decoded step; !rest.empty() || step.produced == block.size(); rest = rest.subspan(step.consumed)) {
    step = decoder.feed(rest, block);
    take(std::span(block).first(step.produced), stream);
    if (step.consumed == 0 && step.produced == 0) break;
  }
  stream.dropped += decoder.counters().dropped_events;
  return stream;
}

EventStream read_text(std::string_view text, const std::string& name) {
  const recording::TextEvents read = recording::parse_text_events(text);
  if (read.events.empty())
    throw Error(ExitCode::kBadFile, name,
                "is neither a Prophesee RAW file nor text events (t x y p), nor a folder with events.raw.");
  EventStream stream;
  stream.dropped = read.malformed + read.out_of_order;
  take(read.events, stream);
  std::uint16_t right = 0;
  std::uint16_t bottom = 0;
  for (const Event& event : stream.events) {
    right = std::max(right, event.x);
    bottom = std::max(bottom, event.y);
  }
  const auto* known = std::find_if(std::begin(kKnownSensors), std::end(kKnownSensors), [&](SensorSize size) {
    return size.width_px > right && size.height_px > bottom;
  });
  if (known == std::end(kKnownSensors))
    throw Error(ExitCode::kBadFile, name, "has events beyond 2048 x 2048 pixels: is it t x y p?");
  stream.size = *known;
  return stream;
}

}  // namespace

EventStream read_event_stream(const std::filesystem::path& path) {
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(path, ignored);
  const std::filesystem::path file_path = is_folder ? path / "events.raw" : path;
  const recording::MappedFile file(file_path);
  if (file.text().starts_with("% ")) return read_raw(file.bytes(), file_path.string());
  return read_text(file.text(), file_path.string());
}

}  // namespace egofocus::citysim
