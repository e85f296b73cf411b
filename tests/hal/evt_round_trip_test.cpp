// What the encoders write, the decoders give back: times over many wraps included.
#include <catch2/catch.hpp>
#include <random>

#include "evt_printing.hpp"
#include "hal/evt21_encoder.hpp"
#include "hal/evt2_encoder.hpp"
#include "hal/evt3_encoder.hpp"
#include "hal/evt_decoder.hpp"
#include "made_evt_words.hpp"

using namespace egofocus;
using evt_words::Bytes;
using Events = std::vector<Event>;

namespace {

constexpr SensorSize kHd{1280, 720};

// Sorted events: rows of close pixels, single ones, bursts, pauses from 1 us to `longest_us`.
Events random_events(unsigned seed, std::size_t count, std::int64_t longest_us) {
  std::mt19937_64 random(seed);
  const auto below = [&](std::uint64_t n) { return random() % n; };
  Events events;
  std::int64_t t = static_cast<std::int64_t>(below(static_cast<std::uint64_t>(longest_us)));
  while (events.size() < count) {
    if (below(3) == 0) t += static_cast<std::int64_t>(below(5));
    if (below(50) == 0) t += static_cast<std::int64_t>(below(static_cast<std::uint64_t>(longest_us)));
    Event event{t, static_cast<std::uint16_t>(below(1280)), static_cast<std::uint16_t>(below(720)),
                static_cast<std::uint8_t>(below(2))};
    const std::uint64_t in_row = below(4) == 0 ? 1 + below(40) : 1;
    for (std::uint64_t i = 0; i < in_row && event.x < 1280; ++i) {
      events.push_back(event);
      event.x = static_cast<std::uint16_t>(event.x + below(4));  // now and then the same pixel again
    }
  }
  return events;
}

template <typename Encoder>
Bytes encode(Encoder& encoder, std::span<const Event> events, std::size_t room,
             std::size_t batch = SIZE_MAX) {
  Bytes bytes;
  Bytes out(room);
  while (!events.empty()) {
    const Decoded done = encoder.encode(events.first(batch < events.size() ? batch : events.size()), out);
    REQUIRE(done.consumed + done.produced > 0);
    bytes.insert(bytes.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(done.produced));
    events = events.subspan(done.consumed);
  }
  return bytes;
}

Bytes encode_as(EvtFormat format, const Events& events, std::size_t room, std::size_t batch) {
  Evt2Encoder evt2;
  Evt21Encoder evt21(format == EvtFormat::kEvt21 ? Evt21Order::kLittleEndian : Evt21Order::kLegacy);
  Evt3Encoder evt3;
  if (format == EvtFormat::kEvt2) return encode(evt2, events, room, batch);
  if (format == EvtFormat::kEvt3) return encode(evt3, events, room, batch);
  return encode(evt21, events, room, batch);
}

}  // namespace

TEST_CASE("EVT: random events survive the round trip") {
  const EvtFormat format =
      GENERATE(EvtFormat::kEvt2, EvtFormat::kEvt21, EvtFormat::kEvt21Legacy, EvtFormat::kEvt3);
  const std::int64_t longest_us =
      GENERATE(std::int64_t{2}, std::int64_t{3000}, std::int64_t{100'000'000}, std::int64_t{20'000'000'000});
  const unsigned seed = GENERATE(1u, 2u, 3u);
  CAPTURE(to_string(format), longest_us, seed);
  const Events events = random_events(seed, 3000, longest_us);
  const std::size_t room = 8 + 8 * (seed - 1) * 50;
  const std::size_t batch = seed == 2 ? 7 : SIZE_MAX;
  const Bytes bytes = encode_as(format, events, room, batch);
  EvtDecoder decoder(format, kHd);
  CHECK(evt_words::decode(decoder, bytes, 100, 1000) == events);
  const EvtCounters& counters = decoder.counters();
  CHECK(counters.events == events.size());
  CHECK(counters.dropped_events == 0);
  for (const std::uint64_t count : counters.violations) CHECK(count == 0);
}

TEST_CASE("EVT3: vectors are used where they are shorter") {
  Evt3Encoder encoder;
  Events row;
  for (std::uint16_t x = 100; x < 132; ++x) row.push_back({4096, x, 7, 1});
  CHECK(encode(encoder, row, 1000) ==
        evt_words::evt3::stream({0x8001, 0x6000, 0x0007, 0x3864, 0x4fff, 0x4fff, 0x50ff}));
  SECTION("two events are not worth a base and a vector") {
    const Events pair = {{4097, 5, 7, 0}, {4097, 6, 7, 0}};
    CHECK(encode(encoder, pair, 1000) == evt_words::evt3::stream({0x6001, 0x2005, 0x2006}));
  }
  SECTION("three are") {
    const Events three = {{4096, 5, 7, 0}, {4096, 6, 7, 0}, {4096, 16, 7, 0}};
    CHECK(encode(encoder, three, 1000) == evt_words::evt3::stream({0x3005, 0x4803}));
  }
}

TEST_CASE("EVT3: a silence of a minute is bridged by steps below 8 s") {
  Evt3Encoder encoder;
  const Bytes bytes = encode(encoder, Events{{0, 1, 1, 1}, {60'000'000, 2, 2, 1}}, 1000);
  std::int64_t last = -1;
  int words = 0;
  for (std::size_t i = 0; i < bytes.size(); i += 2) {
    const int word = std::to_integer<int>(bytes[i]) | std::to_integer<int>(bytes[i + 1]) << 8;
    if (word >> 12 != 8) continue;
    ++words;
    if (last >= 0) CHECK((((word & 0xfff) - last) & 0xfff) * 4096 < 8'000'000);
    last = word & 0xfff;
  }
  CHECK(words > 60 / 8);
}

TEST_CASE("EVT encoders leave out what the format cannot say") {
  const Events events = {{-1, 1, 1, 1},         {100'000, 2, 2, 1}, {100'000, 2048, 2, 1},
                         {100'000, 2, 2048, 1}, {90'000, 3, 3, 0},  {INT64_MAX, 1, 1, 1}};
  const EvtFormat format = GENERATE(EvtFormat::kEvt2, EvtFormat::kEvt21, EvtFormat::kEvt3);
  EvtDecoder decoder(format, kHd);
  CHECK(evt_words::decode(decoder, encode_as(format, events, 100, SIZE_MAX)) == Events{{100'000, 2, 2, 1}});
  Evt3Encoder encoder;
  encode(encoder, events, 100);
  CHECK(encoder.counters().events == 1);
  CHECK(encoder.counters().not_encodable == 5);
}
