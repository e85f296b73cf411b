#include <catch2/catch.hpp>

#include "evt_printing.hpp"
#include "hal/evt21_decoder.hpp"
#include "made_evt_words.hpp"

using namespace egofocus;
using namespace evt_words;
using namespace evt_words::evt21;
using Events = std::vector<Event>;

namespace {

constexpr SensorSize kHd{1280, 720};

struct Outcome {
  Events events;
  EvtCounters counters;
  std::uint64_t operator[](EvtViolation kind) const { return counters[kind]; }
};

Outcome run(const Bytes& bytes, Evt21Order order = Evt21Order::kLittleEndian) {
  Evt21Decoder decoder(kHd, order);
  Outcome outcome{.events = decode(decoder, bytes), .counters = {}};
  outcome.counters = decoder.counters();
  return outcome;
}

}  // namespace

TEST_CASE("EVT2.1: one word brings the pixels of its mask, smallest x first") {
  // Upper 0x1105015E: ON, low 4, x 0b00000101000 ... spelled out: (4 << 22) | (0xA0 << 11) | 0x15E.
  const Bytes bytes = stream({{0x80000010u, 0}, {0x1105015Eu, 0x80000005u}});
  CHECK(run(bytes).events ==
        Events{{0x10 * 64 + 4, 160, 350, 1}, {0x10 * 64 + 4, 162, 350, 1}, {0x10 * 64 + 4, 191, 350, 1}});
}

TEST_CASE("EVT2.1: legacy order has the halves exchanged, and only that") {
  const std::initializer_list<Word> words = {time_high(3), cd(0, 1, 64, 5, 0x11),
                                             cd(1, 2, 96, 6, 0xffffffff)};
  const Events expected = run(stream(words)).events;
  REQUIRE(expected.size() == 34);
  CHECK(run(stream(words, true), Evt21Order::kLegacy).events == expected);
  CHECK(run(stream(words, true), Evt21Order::kLittleEndian).events != expected);
  const Bytes first = stream({time_high(3)}, true);
  CHECK(first == Bytes{std::byte{3}, {}, {}, std::byte{0x80}, {}, {}, {}, {}});
}

TEST_CASE("EVT2.1: events before the first TIME_HIGH are counted pixel by pixel") {
  const Outcome outcome = run(stream({cd(1, 0, 0, 0, 0xff), time_high(0), cd(1, 0, 0, 0, 1)}));
  CHECK(outcome.events.size() == 1);
  CHECK(outcome[EvtViolation::kBeforeTimeHigh] == 1);
  CHECK(outcome.counters.dropped_events == 8);
}

TEST_CASE("EVT2.1: only the pixels inside the sensor survive") {
  const Outcome outcome = run(stream({time_high(0), cd(1, 0, 1279, 0, 0xffffffff), cd(1, 0, 1280, 0, 3),
                                      cd(1, 0, 2047, 0, 3), cd(1, 0, 0, 720, 7)}));
  CHECK(outcome.events == Events{{0, 1279, 0, 1}});
  CHECK(outcome.counters.dropped_events == 31 + 2 + 2 + 3);
  CHECK(outcome[EvtViolation::kOutOfRange] == 4);
}

TEST_CASE("EVT2.1: wrap, step back, triggers, counters, unknown words, empty masks") {
  Evt21Decoder decoder(kHd, Evt21Order::kLittleEndian);
  const Events events = decode(decoder, stream({time_high(0xfffffff),
                                                time_high(0),
                                                cd(1, 1, 0, 0, 0),
                                                cd(1, 2, 0, 0, 1),
                                                {0x84000000u, 0},
                                                time_high(0x3ffffff),
                                                trigger(9, 4, 1),
                                                others(0x14, 123456789),
                                                others(0x16, 5),
                                                others(0x14, 1),
                                                {0xF0000000u, 99},
                                                {0x20000000u, 0xffffffff}}));
  CHECK(events == Events{{(1LL << 34) + 2, 0, 0, 1}});
  const EvtCounters& counters = decoder.counters();
  CHECK(counters[EvtViolation::kTimeHighBackward] == 1);
  CHECK(counters[EvtViolation::kUnknownWord] == 1);
  CHECK(counters.sensor_in == 123456790);
  CHECK(counters.sensor_out == 5);
  CHECK(counters.triggers == 1);
  CHECK(decoder.last_trigger().t_us == (1LL << 34) + 0x4000000LL * 64 + 9);
  CHECK(decoder.last_trigger().id == 4);
  CHECK(decoder.last_trigger().value == 1);
}

TEST_CASE("EVT2.1: neither cuts of the input nor small outputs change anything") {
  const Bytes bytes =
      stream({time_high(7), cd(1, 1, 32, 20, 0xf00f), cd(0, 2, 64, 40, 1), cd(1, 3, 96, 60, 0x80000001)});
  const Events whole = run(bytes).events;
  REQUIRE(whole.size() == 11);
  for (std::size_t cut = 1; cut <= bytes.size(); ++cut) {
    for (std::size_t room = 1; room <= 12; ++room) {
      Evt21Decoder decoder(kHd, Evt21Order::kLittleEndian);
      CHECK(decode(decoder, bytes, room, cut) == whole);
    }
  }
}

TEST_CASE("EVT2.1: a word that found no room goes on in the next call") {
  Evt21Decoder decoder(kHd, Evt21Order::kLittleEndian);
  const Bytes bytes = stream({time_high(0), cd(1, 0, 0, 0, 7)});
  Event out[2];
  Decoded done = decoder.feed(bytes, out);
  CHECK(done.consumed == 16);
  CHECK(done.produced == 2);
  done = decoder.feed({}, out);
  CHECK(done.produced == 1);
  CHECK(out[0] == Event{0, 2, 0, 1});
}
