// Recordings of real cameras, read in place. The expected numbers were counted by a separate reader.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numeric>
#include <string>

#include "evt_printing.hpp"
#include "hal/evt3_decoder.hpp"
#include "hal/evt_decoder.hpp"
#include "made_evt_words.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using evt_words::Bytes;

namespace {

std::string stream_path(const std::string& name) {
  const char* folder = std::getenv("EGOFOCUS_REAL_DATA");
  return (folder != nullptr ? std::string(folder) : egofocus::test::source_dir() + "/../shared/real") +
         "/streams/" + name;
}

// Empty, with a message, where the recordings are not at hand.
Bytes read_stream(const std::string& name) {
  std::ifstream file(stream_path(name), std::ios::binary);
  if (!file)
    WARN("skipped: no " << stream_path(name) << " (set EGOFOCUS_REAL_DATA to the folder that has streams/)");
  const std::string content((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto bytes = std::as_bytes(std::span(content));
  return Bytes(bytes.begin(), bytes.end());
}

struct Sums {
  std::uint64_t on = 0;
  std::uint64_t x = 0;
  std::uint64_t y = 0;
};

Sums sums_of(const std::vector<Event>& events) {
  Sums sums;
  for (const Event& event : events) {
    sums.on += event.polarity;
    sums.x += event.x;
    sums.y += event.y;
  }
  return sums;
}

std::uint64_t violations_of(const EvtCounters& counters) {
  return std::accumulate(counters.violations.begin(), counters.violations.end(), std::uint64_t{0});
}

std::uint32_t u32_at(const Bytes& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | std::to_integer<std::uint32_t>(bytes.at(at + i));
  return value;
}

}  // namespace

TEST_CASE("real: an EVT2 recording of a Gen3 camera decodes completely") {
  const Bytes file = read_stream("faery_evt2.raw");
  if (file.empty()) return;
  RawHeader header;
  REQUIRE(parse_raw_header(file, header).ok());
  CHECK(header.format == EvtFormat::kEvt2);
  CHECK(header.size.width_px == 640);
  CHECK(header.size.height_px == 480);
  CHECK(header.header_bytes == 166);
  EvtDecoder decoder(header.format, header.size);
  const std::vector<Event> events =
      evt_words::decode(decoder, std::span(file).subspan(header.header_bytes), 4096, 10007);
  REQUIRE(events.size() == 521252);
  CHECK(events.front().t_us == 913716224);
  CHECK(events.back().t_us == 913812095);
  const Sums sums = sums_of(events);
  CHECK(sums.on == 185861);
  CHECK(sums.x == 128979953);
  CHECK(sums.y == 216346680);
  CHECK(violations_of(decoder.counters()) == 0);
}

// ROS 1 bag, uncompressed: each event_camera_msgs/EventPacket holds the encoding as a counted string, a byte
// for the byte order, then the counted words.
TEST_CASE("real: EVT3 packets of a ROS bag decode completely") {
  const Bytes bag = read_stream("ecpy_test_events_1.bag");
  if (bag.empty()) return;
  Bytes marker;
  for (const char c : {'\4', '\0', '\0', '\0', 'e', 'v', 't', '3'})
    marker.push_back(static_cast<std::byte>(c));
  Evt3Decoder decoder({640, 480});
  std::vector<Event> events;
  int packets = 0;
  for (auto at = bag.begin();;) {
    at = std::search(at, bag.end(), marker.begin(), marker.end());
    if (at == bag.end()) break;
    const std::size_t size_at = static_cast<std::size_t>(at - bag.begin()) + marker.size() + 1;
    const std::size_t size = u32_at(bag, size_at);
    REQUIRE(size_at + 4 + size <= bag.size());
    const std::vector<Event> some =
        evt_words::decode(decoder, std::span(bag).subspan(size_at + 4, size), 1000);
    events.insert(events.end(), some.begin(), some.end());
    at += static_cast<std::ptrdiff_t>(size);
    ++packets;
  }
  CHECK(packets == 517);
  REQUIRE(events.size() == 343474);
  CHECK(events.front().t_us == 7139845);
  CHECK(events.back().t_us == 9218023);
  const Sums sums = sums_of(events);
  CHECK(sums.on == 125183);
  CHECK(sums.x == 116731888);
  CHECK(sums.y == 80879209);
  CHECK(decoder.counters().triggers == 4157);
  CHECK(violations_of(decoder.counters()) == 0);
}
