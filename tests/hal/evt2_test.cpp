#include <catch2/catch.hpp>

#include "evt_printing.hpp"
#include "hal/evt2_decoder.hpp"
#include "made_evt_words.hpp"

using namespace egofocus;
using namespace evt_words;
using namespace evt_words::evt2;
using Events = std::vector<Event>;

namespace {

constexpr SensorSize kVga{640, 480};

struct Outcome {
  Events events;
  EvtCounters counters;
  std::uint64_t operator[](EvtViolation kind) const { return counters[kind]; }
};

Outcome run(const Bytes& bytes) {
  Evt2Decoder decoder(kVga);
  Outcome outcome{.events = decode(decoder, bytes), .counters = {}};
  outcome.counters = decoder.counters();
  return outcome;
}

}  // namespace

TEST_CASE("EVT2: an empty stream has no events") {
  CHECK(run({}).events.empty());
}

TEST_CASE("EVT2: fields of events and time") {
  // 0x80000123: TIME_HIGH 0x123; 0x1AC85107: ON, low 0b101011 = 43, x = 0b00100001010 = 266, y = 0x107 = 263.
  const Outcome outcome = run(stream({0x80000123u, 0x1AC85107u, 0x0FC00000u}));
  CHECK(outcome.events == Events{{0x123 * 64 + 43, 266, 263, 1}, {0x123 * 64 + 63, 0, 0, 0}});
  CHECK(outcome.counters.events == 2);
  CHECK(outcome.counters.dropped_events == 0);
}

TEST_CASE("EVT2: events before the first TIME_HIGH are dropped and counted") {
  const Outcome outcome = run(stream({cd(1, 3, 1, 1), cd(0, 4, 2, 2), time_high(1), cd(1, 5, 3, 3)}));
  CHECK(outcome.events == Events{{69, 3, 3, 1}});
  CHECK(outcome[EvtViolation::kBeforeTimeHigh] == 2);
  CHECK(outcome.counters.dropped_events == 2);
}

TEST_CASE("EVT2: time goes on after the 28-bit counter wraps, again and again") {
  const Outcome outcome =
      run(stream({time_high(0xffffffe), cd(1, 63, 1, 1), time_high(1), cd(1, 0, 1, 1), time_high(0x6000000),
                  time_high(0xc000000), time_high(0), cd(1, 2, 1, 1)}));
  CHECK(outcome.events ==
        Events{{(1LL << 34) - 65, 1, 1, 1}, {(1LL << 34) + 64, 1, 1, 1}, {(2LL << 34) + 2, 1, 1, 1}});
  CHECK(outcome[EvtViolation::kTimeHighBackward] == 0);
}

TEST_CASE("EVT2: a small step back of TIME_HIGH is refused and counted") {
  const Outcome outcome = run(stream({time_high(100), cd(1, 0, 1, 1), time_high(99), cd(1, 1, 2, 2)}));
  CHECK(outcome.events == Events{{6400, 1, 1, 1}, {6401, 2, 2, 1}});
  CHECK(outcome[EvtViolation::kTimeHighBackward] == 1);
}

TEST_CASE("EVT2: pixels outside the sensor are dropped and counted") {
  const Outcome outcome = run(
      stream({time_high(0), cd(1, 0, 640, 0), cd(1, 0, 639, 479), cd(1, 0, 0, 480), cd(1, 0, 2047, 2047)}));
  CHECK(outcome.events == Events{{0, 639, 479, 1}});
  CHECK(outcome[EvtViolation::kOutOfRange] == 3);
  CHECK(outcome.counters.dropped_events == 3);
}

TEST_CASE("EVT2: an event behind its predecessor is given out and counted") {
  const Outcome outcome = run(stream({time_high(0), cd(1, 9, 1, 1), cd(1, 8, 2, 2), cd(1, 8, 3, 3)}));
  CHECK(outcome.events.size() == 3);
  CHECK(outcome[EvtViolation::kEventBackward] == 1);
}

TEST_CASE("EVT2: rate controller counters, IMU and unknown words") {
  const Outcome outcome = run(stream({time_high(0), other(0x14), continued(0x3fffff), other(0x16),
                                      continued(7), other(0x99), continued(1000), other(0x14), 0xD0000000u,
                                      continued(1), continued(2), 0x30000000u, 0x90000000u}));
  CHECK(outcome.counters.sensor_in == 0x3fffff);
  CHECK(outcome.counters.sensor_out == 7);
  CHECK(outcome[EvtViolation::kUnknownWord] == 2);
  CHECK(outcome.events.empty());
}

TEST_CASE("EVT2: triggers are counted and the last is kept") {
  Evt2Decoder decoder(kVga);
  decode(decoder, stream({time_high(2), trigger(5, 6, 1), trigger(7, 31, 0)}));
  CHECK(decoder.counters().triggers == 2);
  CHECK(decoder.last_trigger().t_us == 135);
  CHECK(decoder.last_trigger().id == 31);
  CHECK(decoder.last_trigger().value == 0);
}

TEST_CASE("EVT2: neither cuts of the input nor small outputs change anything") {
  const Bytes bytes =
      stream({time_high(7), cd(1, 1, 10, 20), time_high(8), cd(0, 2, 30, 40), cd(1, 3, 50, 60)});
  const Events whole = run(bytes).events;
  REQUIRE(whole.size() == 3);
  for (std::size_t cut = 1; cut <= bytes.size(); ++cut) {
    for (std::size_t room = 1; room <= 4; ++room) {
      Evt2Decoder decoder(kVga);
      CHECK(decode(decoder, bytes, room, cut) == whole);
    }
  }
}

TEST_CASE("EVT2: no room, nothing taken") {
  Evt2Decoder decoder(kVga);
  const Decoded done = decoder.feed(stream({time_high(7)}), {});
  CHECK(done.consumed == 0);
  CHECK(done.produced == 0);
}
