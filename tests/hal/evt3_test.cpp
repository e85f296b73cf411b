#include <catch2/catch.hpp>

#include "evt_printing.hpp"
#include "hal/evt3_decoder.hpp"
#include "made_evt_words.hpp"

using namespace egofocus;
using namespace evt_words;
using namespace evt_words::evt3;
using Events = std::vector<Event>;

namespace {

constexpr SensorSize kHd{1280, 720};
constexpr std::int64_t kEpoch = 1LL << 24;

struct Outcome {
  Events events;
  EvtCounters counters;
  std::uint64_t operator[](EvtViolation kind) const { return counters[kind]; }
  std::vector<std::int64_t> times() const {
    std::vector<std::int64_t> times;
    for (const Event& event : events) times.push_back(event.t_us);
    return times;
  }
};

Outcome run(const Bytes& bytes) {
  Evt3Decoder decoder(kHd);
  Outcome outcome{.events = decode(decoder, bytes), .counters = {}};
  outcome.counters = decoder.counters();
  return outcome;
}

}  // namespace

TEST_CASE("EVT3: single events, in hand-made bytes") {
  // TIME_HIGH 0x123, TIME_LOW 0x456, Y 0x0AB, X 0x102 OFF, X 0x103 ON.
  const unsigned char raw[] = {0x23, 0x81, 0x56, 0x64, 0xAB, 0x00, 0x02, 0x21, 0x03, 0x29};
  const Outcome outcome =
      run(Bytes(reinterpret_cast<const std::byte*>(raw), reinterpret_cast<const std::byte*>(raw) + 10));
  CHECK(outcome.events == Events{{0x123456, 0x102, 0xAB, 0}, {0x123456, 0x103, 0xAB, 1}});
  CHECK(outcome.counters.dropped_events == 0);
}

TEST_CASE("EVT3: vectors advance their base by 12, 12 and 8") {
  const Outcome outcome = run(stream({time_high(0), time_low(5), addr_y(9), base_x(1, 100), vect12(0x801),
                                      vect12(0x002), vect8(0x80), vect12(0x001)}));
  CHECK(outcome.events ==
        Events{{5, 100, 9, 1}, {5, 111, 9, 1}, {5, 113, 9, 1}, {5, 131, 9, 1}, {5, 132, 9, 1}});
}

TEST_CASE("EVT3: a base outlives rows and times") {
  const Outcome outcome =
      run(stream({time_high(0), addr_y(1), base_x(0, 10), addr_y(2), time_low(7), vect12(1)}));
  CHECK(outcome.events == Events{{7, 10, 2, 0}});
}

TEST_CASE("EVT3: all before the first TIME_HIGH is dropped, its events counted") {
  const Outcome outcome = run(stream({time_low(3), addr_y(1), addr_x(1, 1), base_x(1, 0), vect12(0xfff),
                                      vect8(0x0f), time_high(0), addr_x(1, 2), vect8(0xff)}));
  CHECK(outcome.events.empty());
  CHECK(outcome[EvtViolation::kBeforeTimeHigh] == 3);
  CHECK(outcome[EvtViolation::kBeforeY] == 1);
  CHECK(outcome[EvtViolation::kBeforeBase] == 1);
  CHECK(outcome.counters.dropped_events == 1 + 12 + 4 + 1 + 8);
}

TEST_CASE("EVT3: a new TIME_HIGH starts TIME_LOW at 0, a repeated one leaves it") {
  const Outcome outcome = run(stream({time_high(1), time_low(50), addr_y(0), addr_x(1, 1), time_high(1),
                                      addr_x(1, 2), time_high(2), addr_x(1, 3), time_low(4), addr_x(1, 4)}));
  CHECK(outcome.times() == std::vector<std::int64_t>{4096 + 50, 4096 + 50, 8192, 8196});
}

TEST_CASE("EVT3: each wrap of TIME_HIGH adds 2^24 us") {
  const Outcome outcome =
      run(stream({time_high(0xffe), addr_y(0), addr_x(1, 0), time_high(0xfff), addr_x(1, 0), time_high(0),
                  addr_x(1, 0), time_high(0x7ff), time_high(0xffe), time_high(1), addr_x(1, 0)}));
  CHECK(outcome.times() == std::vector<std::int64_t>{0xffe000, 0xfff000, kEpoch, 2 * kEpoch + 4096});
  CHECK(outcome[EvtViolation::kTimeHighBackward] + outcome[EvtViolation::kTimeHighLeap] == 0);
}

TEST_CASE("EVT3: the border between a wrap and a step back is half the range") {
  SECTION("back by 2^11: a wrap") {
    const Outcome outcome = run(stream({time_high(0x900), time_high(0x100), addr_y(0), addr_x(1, 0)}));
    CHECK(outcome.times() == std::vector<std::int64_t>{kEpoch + 0x100000});
  }
  SECTION("back by less: refused") {
    const Outcome outcome = run(stream({time_high(0x900), time_high(0x101), addr_y(0), addr_x(1, 0)}));
    CHECK(outcome.times() == std::vector<std::int64_t>{0x900000});
    CHECK(outcome[EvtViolation::kTimeHighBackward] == 1);
  }
  SECTION("ahead by 2^11 - 1: a long silence") {
    const Outcome outcome = run(stream({time_high(0), time_high(0x7ff), addr_y(0), addr_x(1, 0)}));
    CHECK(outcome.times() == std::vector<std::int64_t>{0x7ff000});
  }
  SECTION("ahead by 2^11: refused") {
    const Outcome outcome = run(stream({time_high(0), time_high(0x800), addr_y(0), addr_x(1, 0)}));
    CHECK(outcome.times() == std::vector<std::int64_t>{0});
    CHECK(outcome[EvtViolation::kTimeHighLeap] == 1);
  }
}

TEST_CASE("EVT3: after one corrupt TIME_HIGH the true ones win in the end") {
  Bytes bytes = stream({time_high(10), time_high(1000), addr_y(0)});
  for (int i = 0; i < 16; ++i) append(bytes, time_high(11), 2);
  append(bytes, addr_x(1, 5), 2);
  const Outcome outcome = run(bytes);
  CHECK(outcome.times() == std::vector<std::int64_t>{11 * 4096});
  CHECK(outcome[EvtViolation::kTimeHighBackward] == 16);
  CHECK(outcome[EvtViolation::kTimeReset] == 1);
}

TEST_CASE("EVT3: TIME_LOW that steps back, and the events behind it, are counted") {
  const Outcome outcome = run(
      stream({time_high(0), addr_y(0), time_low(9), addr_x(1, 0), time_low(8), addr_x(1, 1), addr_x(1, 2)}));
  CHECK(outcome.times() == std::vector<std::int64_t>{9, 8, 8});
  CHECK(outcome[EvtViolation::kTimeLowBackward] == 1);
  CHECK(outcome[EvtViolation::kEventBackward] == 1);
}

TEST_CASE("EVT3: events outside the sensor are dropped, not clamped") {
  const Outcome outcome =
      run(stream({time_high(0), addr_y(720), addr_x(1, 0), base_x(1, 0), vect12(0xfff), addr_y(719),
                  addr_x(1, 1280), addr_x(1, 1279), base_x(0, 1270), vect12(0xfff), vect12(0xfff)}));
  CHECK(outcome.events.size() == 11);
  CHECK(outcome.events[0] == Event{0, 1279, 719, 1});
  CHECK(outcome.events[10] == Event{0, 1279, 719, 0});
  CHECK(outcome.counters.dropped_events == 1 + 12 + 1 + 2 + 12);
  CHECK(outcome[EvtViolation::kOutOfRange] == 5);
}

TEST_CASE("EVT3: endless vectors run off the sensor and stay there") {
  Bytes bytes = stream({time_high(0), addr_y(0), base_x(1, 0)});
  for (int i = 0; i < 10000; ++i) append(bytes, vect12(1), 2);
  const Outcome outcome = run(bytes);
  CHECK(outcome.events.size() == 107);  // x = 0, 12, ... 1272
  CHECK(outcome.counters.dropped_events == 10000 - 107);
}

TEST_CASE("EVT3: padding and undefined types are skipped and counted") {
  const Outcome outcome =
      run(stream({time_high(0), 0x9999, addr_y(0), 0x1000, 0xB000, 0xCfff, addr_x(1, 3), 0x9999}));
  CHECK(outcome.events == Events{{0, 3, 0, 1}});
  CHECK(outcome[EvtViolation::kUnknownWord] == 5);
}

TEST_CASE("EVT3: CONTINUED words never disturb") {
  const Outcome outcome =
      run(stream({continued4(1), time_high(0), continued4(0xf), addr_y(0), continued12(0xfff), continued4(5),
                  0xD000, continued12(1), addr_x(1, 3)}));
  CHECK(outcome.events == Events{{0, 3, 0, 1}});
  CHECK(outcome.counters.sensor_in == 0);
}

TEST_CASE("EVT3: rate controller counters come low bits first, the last 4 may be missing") {
  SECTION("28 bits") {
    const Outcome outcome =
        run(stream({time_high(0), others(0x14), continued12(0x123), continued12(0x456), continued4(7)}));
    CHECK(outcome.counters.sensor_in == 0x7456123);
  }
  SECTION("24 bits, then another OTHERS") {
    const Outcome outcome =
        run(stream({time_high(0), others(0x16), continued12(0x001), continued12(0x002), others(0x14),
                    continued12(0x003), continued12(0), continued4(0), continued4(9)}));
    CHECK(outcome.counters.sensor_out == 0x2001);
    CHECK(outcome.counters.sensor_in == 3);
  }
  SECTION("another subtype") {
    CHECK(run(stream({time_high(0), others(0x19), continued12(5), continued12(5)})).counters.sensor_in == 0);
  }
}

TEST_CASE("EVT3: triggers are counted and the last is kept") {
  Evt3Decoder decoder(kHd);
  decode(decoder, stream({trigger(1, 1), time_high(2), time_low(5), trigger(3, 1)}));
  CHECK(decoder.counters().triggers == 1);
  CHECK(decoder.last_trigger().t_us == 2 * 4096 + 5);
  CHECK(decoder.last_trigger().id == 3);
  CHECK(decoder.last_trigger().value == 1);
}

TEST_CASE("EVT3: neither cuts of the input nor small outputs change anything") {
  const Bytes bytes = stream({time_high(7), time_low(1), addr_y(3), addr_x(1, 5), base_x(0, 9), vect12(0xa5a),
                              vect12(0xfff), vect8(0x81), time_low(2), addr_x(0, 1)});
  const Events whole = run(bytes).events;
  REQUIRE(whole.size() == 1 + 6 + 12 + 2 + 1);
  for (std::size_t cut = 1; cut <= bytes.size(); ++cut) {
    for (std::size_t room = 1; room <= 14; ++room) {
      Evt3Decoder decoder(kHd);
      CHECK(decode(decoder, bytes, room, cut) == whole);
    }
  }
}

TEST_CASE("EVT3: a vector that found no room goes on in the next call") {
  Evt3Decoder decoder(kHd);
  const Bytes bytes = stream({time_high(0), addr_y(0), base_x(1, 0), vect12(7), addr_x(1, 50)});
  Event out[2];
  Decoded done = decoder.feed(bytes, out);
  CHECK(done.consumed == 8);
  CHECK(done.produced == 2);
  done = decoder.feed(std::span(bytes).subspan(8), out);
  CHECK(done.consumed == 2);
  CHECK(done.produced == 2);
  CHECK(out[0] == Event{0, 2, 0, 1});
  CHECK(out[1] == Event{0, 50, 0, 1});
}
