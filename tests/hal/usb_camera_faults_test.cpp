// Everything that a bus and a camera can do to a stream.
#include <catch2/catch.hpp>
#include <cstring>

#include "evt_printing.hpp"
#include "inivation_stream.hpp"
#include "usb_cameras.hpp"

using namespace scripted;
using inivation::column;
using inivation::row;
using inivation::time_reset;
using inivation::time_stamp;
using inivation::wrap;

namespace {

Ending words(std::initializer_list<inivation::Word> list, int error = 0) {
  return {inivation::stream(list), error};
}

// A DAVIS346 that streams and whose clock is known.
struct Streaming {
  Usb bus;
  std::unique_ptr<Bench> bench;
  explicit Streaming(const UsbCameraSettings& settings = {}) {
    bus.cameras = {davis346()};
    bench = std::make_unique<Bench>(bus, settings);
    REQUIRE(bench->stream());
    feed(words({time_reset(), time_stamp(1), row(1)}));
  }
  void feed(const Ending& ending, int polls = 1) {
    bus.cameras[0].endings.push_back(ending);
    bench->poll(polls);
  }
  UsbCameraCounters counters() const { return bench->source.counters(); }
  /// Events that get through now.
  std::size_t heard() {
    bench->events();
    feed(words({wrap(1), row(1), column(1, 9)}), 3);
    feed(words({wrap(1), row(1), column(1, 9)}), 3);
    return bench->events().size();
  }
};

UsbCameraSettings without_reopen() {
  UsbCameraSettings settings;
  settings.reopen = false;
  return settings;
}

}  // namespace

TEST_CASE("USB fault: a stall clears the halt once and sends all transfers again") {
  Streaming s;
  s.feed(words({time_stamp(5), column(1, 2)}, EPIPE), 3);
  CHECK(s.counters().stalls == 1);
  CHECK(s.counters().lost == 0);
  CHECK(s.bus.halts_cleared == 2);  // once at the start
  CHECK(s.bus.in_flight() == 16);
  CHECK(s.bench->events().size() == 1);  // what came with the stall counts
  CHECK(s.heard() == 2);
}

TEST_CASE("USB fault: a camera that does nothing but stall is lost, and looked for again") {
  Streaming s;
  for (int i = 0; i < 8; ++i) s.feed({{}, EPIPE}, 3);
  CHECK(s.counters().stalls == 8);
  CHECK(s.counters().lost == 1);
  CHECK(s.counters().last_error.code() == StatusCode::kDeviceLost);
  CHECK(s.counters().last_error.value() == EPIPE);
  CHECK(s.bench->poll_until(UsbCameraPhase::kStreaming));
  CHECK(s.counters().opened == 2);
}

TEST_CASE("USB fault: overflow loses one transfer and is counted") {
  Streaming s;
  s.feed({{}, EOVERFLOW});
  CHECK(s.counters().overflows == 1);
  CHECK(s.heard() == 2);
  CHECK(s.counters().lost == 0);
}

TEST_CASE("USB fault: single failures are survived, endless ones are not") {
  Streaming s;
  for (int i = 0; i < 20; ++i) {
    s.feed({{}, EIO});
    s.feed(words({wrap(1)}));
  }
  CHECK(s.counters().failed == 20);
  CHECK(s.counters().lost == 0);
  for (int i = 0; i < 8; ++i) s.feed({{}, EIO});
  CHECK(s.counters().lost == 1);
}

TEST_CASE("USB fault: short, odd and empty transfers") {
  Streaming s;
  Ending odd = words({time_stamp(9), column(1, 4)});
  odd.bytes.push_back(std::byte{0x31});
  s.feed(odd);
  s.feed({});
  s.feed(words({column(1, 5)}));
  const std::vector<Event> events = s.bench->events();
  REQUIRE(events.size() == 2);
  CHECK(events[1].x == 5);
  CHECK(s.counters().inivation[InivationViolation::kOddByte] == 1);
}

TEST_CASE("USB fault: corrupt words are counted, events outside the array never get through") {
  Streaming s;
  Bytes noise;
  std::uint32_t state = 12345;
  for (int i = 0; i < 8000; ++i) evt_words::append(noise, (state = state * 1664525 + 1013904223) >> 16, 2);
  s.feed({noise, 0});
  s.feed({noise, 0});
  for (const Event& event : s.bench->events()) {
    CHECK(event.x < 346);
    CHECK(event.y < 260);
  }
  CHECK(s.counters().inivation.dropped_events > 0);
  CHECK(s.counters().inivation[InivationViolation::kUnknownWord] > 0);
  CHECK(s.counters().lost == 0);
}

TEST_CASE("USB fault: interruptions are no errors") {
  Streaming s;
  s.bus.interruptions = 5;
  for (int i = 0; i < 5; ++i) CHECK(s.bench->poll().status.ok());
  CHECK(s.heard() == 2);
}

TEST_CASE("USB fault: unplugged with all transfers in flight, and back") {
  Streaming s;
  REQUIRE(s.bus.in_flight() == 16);
  s.bus.cameras[0].is_plugged = false;
  const std::int64_t before_us = s.bus.clock.now_us();
  CHECK(s.bench->poll().status.ok());  // reopening is the source's own business
  CHECK(s.bus.clock.now_us() - before_us <= 20'000);
  CHECK(s.counters().phase == UsbCameraPhase::kClosed);
  CHECK(s.counters().last_error.value() == ENODEV);
  CHECK(s.bus.all_closed());
  s.bench->poll(1000);  // 10 s without it
  CHECK(s.counters().refused >= 5);
  CHECK(s.counters().refused <= 10);  // 0.1, 0.2, 0.4, 0.8, 1.6, 2, 2, 2 s
  CHECK(s.bus.all_closed());
  s.bus.cameras[0].is_plugged = true;
  REQUIRE(s.bench->poll_until(UsbCameraPhase::kStreaming));
  s.feed(words({time_reset(), time_stamp(1)}));
  CHECK(s.heard() == 2);
  CHECK(s.counters().lost == 1);
  CHECK(s.counters().opened == 2);
}

TEST_CASE("USB fault: without reopening a loss is a status that stays") {
  Streaming s(without_reopen());
  s.bus.cameras[0].is_plugged = false;
  CHECK(s.bench->poll().status.code() == StatusCode::kDeviceLost);
  CHECK(s.bench->poll().status.code() == StatusCode::kDeviceLost);
  CHECK(s.bus.all_closed());
  char text[200];
  s.bench->poll().status.describe(text);
  CHECK(std::string(text).find("device lost: while it was streaming") == 0);
}

TEST_CASE("USB fault: another camera never takes the place of a lost one") {
  Streaming s;
  s.bus.cameras[0].is_plugged = false;
  s.bench->poll();
  s.bus.cameras.push_back(davis346("99999999"));
  s.bench->poll(500);
  CHECK(s.counters().phase == UsbCameraPhase::kClosed);
  CHECK(s.counters().last_error.code() == StatusCode::kNoDevice);
  s.bus.cameras[0].is_plugged = true;
  CHECK(s.bench->poll_until(UsbCameraPhase::kStreaming));
}

TEST_CASE("USB fault: silence of a second is a loss") {
  Streaming s;
  s.bench->poll(95);
  CHECK(s.counters().lost == 0);
  s.bench->poll(10);
  CHECK(s.counters().lost == 1);
  CHECK(s.counters().last_error.value() == ETIMEDOUT);
}

TEST_CASE("USB fault: transfers that never come back do not hang a stop") {
  Streaming s;
  s.bus.is_hung = true;
  const std::int64_t before_us = s.bus.clock.now_us();
  s.bench->source.stop();
  CHECK(s.bus.clock.now_us() - before_us <= 1'100'000);
  CHECK(s.bus.all_closed());
}

TEST_CASE("USB fault: a camera that no longer answers is not asked twice when it is stopped") {
  Streaming s;
  s.bus.fail_control_after = 0;
  s.bench->source.stop();
  CHECK(s.bus.cameras[0].writes.back().address == at(1, 3));  // the last one of the start
  CHECK(s.bus.all_closed());
}

TEST_CASE("USB fault: a transfer that cannot be sent is a loss") {
  Streaming s;
  s.bus.fail_submit_after = 0;
  s.feed(words({wrap(1)}));
  CHECK(s.counters().lost == 1);
  CHECK(s.bus.all_closed());
}

TEST_CASE("USB fault: unplugged and back 20 times, at any moment, leaks nothing") {
  Streaming s;
  std::int64_t newest_us = 0;
  for (int i = 0; i < 20; ++i) {
    s.bus.cameras[0].is_plugged = false;
    s.bench->poll(1 + i);
    CHECK(s.bus.all_closed());
    s.bus.cameras[0].is_plugged = true;
    // Every third time it goes again while it is still being started.
    if (i % 3 == 0) {
      REQUIRE(s.bench->poll_until(UsbCameraPhase::kStarting));
      s.bench->poll(i);
      s.bus.cameras[0].is_plugged = false;
      s.bench->poll(40);
      CHECK(s.bus.all_closed());
      s.bus.cameras[0].is_plugged = true;
    }
    REQUIRE(s.bench->poll_until(UsbCameraPhase::kStreaming));
    CHECK(s.bus.in_flight() == 16);
    s.feed(words({time_reset(), time_stamp(1), row(1)}));
    s.feed(words({time_stamp(2), column(1, 1)}));
    const std::vector<Event> events = s.bench->events();
    REQUIRE(events.size() == 1);
    CHECK(events[0].t_us > newest_us);  // the host's time goes on over the camera's resets
    newest_us = events[0].t_us;
  }
  CHECK(s.counters().lost == 27);
  CHECK(s.counters().opened == 28);
  CHECK(s.counters().inivation.events == 20);
  s.bench->source.stop();
  CHECK(s.bus.all_closed());
}

TEST_CASE("USB fault: stop and start again, and a source that is destroyed while it streams") {
  Usb bus;
  bus.cameras = {davis346()};
  {
    Bench bench(bus);
    for (int i = 0; i < 3; ++i) {
      REQUIRE(bench.stream());
      bench.source.stop();
      CHECK(bus.all_closed());
    }
    REQUIRE(bench.stream());
    CHECK(bus.in_flight() == 16);
  }
  CHECK(bus.all_closed());
}
