// Bytes of a camera become samples on the host's clock.
#include <catch2/catch.hpp>

#include "evt_printing.hpp"
#include "inivation_stream.hpp"
#include "usb_cameras.hpp"

using namespace scripted;
using inivation::append_imu;
using inivation::column;
using inivation::row;
using inivation::time_reset;
using inivation::time_stamp;
using inivation::wrap;

namespace {

Ending words(std::initializer_list<inivation::Word> list) {
  return {inivation::stream(list), 0};
}

// A transfer that sets the camera's clock, so that the next ones can be mapped.
Ending first_time() {
  return words({time_reset(), time_stamp(1)});
}

}  // namespace

TEST_CASE("USB: events get the host's time, in device order") {
  Usb bus;
  bus.cameras = {davis346()};
  Bench bench(bus);
  REQUIRE(bench.stream());
  auto& endings = bus.cameras[0].endings;
  endings.push_back(first_time());
  bench.poll();
  const std::int64_t zero_us = bus.clock.now_us() - 1;  // device time 1 was seen then
  endings.push_back(words({time_stamp(50), row(3), column(1, 4), time_stamp(90), column(0, 5)}));
  const Delivery delivery = bench.poll();
  CHECK(bench.events() == std::vector<Event>{{zero_us + 50, 4, 3, 1}, {zero_us + 90, 5, 3, 0}});
  CHECK(delivery.status.ok());
  CHECK_FALSE(delivery.ended);
  CHECK(delivery.watermark_us == zero_us + 89);
  CHECK(bench.source.counters().events_pushed == 2);
  CHECK(bench.source.counters().inivation.events == 2);
}

TEST_CASE("USB: with device_time events keep the camera's time, from the first one on") {
  Usb bus;
  bus.cameras = {davis346()};
  UsbCameraSettings settings;
  settings.device_time = true;
  Bench bench(bus, settings);
  REQUIRE(bench.stream());
  bus.cameras[0].endings.push_back(
      words({time_reset(), time_stamp(50), row(3), column(1, 4), time_stamp(90)}));
  CHECK(bench.poll().watermark_us == 89);
  CHECK(bench.events() == std::vector<Event>{{50, 4, 3, 1}});
  bus.clock.set(bus.clock.now_us() + 1'000'000);  // whatever the host's clock does
  bus.cameras[0].endings.push_back(words({time_stamp(95), column(0, 5)}));
  CHECK(bench.poll().watermark_us == 94);
  CHECK(bench.events() == std::vector<Event>{{95, 5, 3, 0}});
  CHECK(bench.source.counters().events_unmapped == 0);
}

TEST_CASE("USB: what comes before the clock is known, or before the start is over, is dropped and counted") {
  Usb bus;
  bus.cameras = {davis346()};
  Bench bench(bus);
  REQUIRE(bench.source.start().ok());
  // Left over from another run: it ends while the camera is still being started.
  bus.cameras[0].endings = {words({time_stamp(50), row(3), column(1, 4)}),
                            words({time_stamp(60), column(1, 4)})};
  REQUIRE(bench.poll_until(UsbCameraPhase::kStreaming));
  CHECK(bench.source.counters().transfers == 2);
  CHECK(bench.source.counters().events_unmapped == 2);
  // The reset shows that the time before it was another one.
  bus.cameras[0].endings.push_back(
      words({time_stamp(70), column(1, 1), time_reset(), time_stamp(2), column(1, 2)}));
  bench.poll();
  CHECK(bench.source.counters().events_unmapped == 4);
  CHECK(bench.source.counters().clock_restarts == 1);
  CHECK(bench.events().empty());
  bus.cameras[0].endings.push_back(words({time_stamp(3), column(1, 3)}));
  bench.poll();
  CHECK(bench.events().size() == 1);
}

TEST_CASE("USB: the IMU of a DAVIS is a motion source, in the body's axes") {
  Usb bus;
  bus.cameras = {davis346()};
  UsbCameraSettings settings;
  settings.imu = true;
  settings.imu_axes = {{3, -1, 2}};
  Bench bench(bus, settings);
  REQUIRE(bench.stream());
  bus.cameras[0].endings.push_back(first_time());
  bench.poll();
  const std::int64_t zero_us = bus.clock.now_us() - 1;
  Bytes bytes = inivation::stream({time_stamp(500)});
  append_imu(bytes, 0xE0, {16384, 0, -8192, 0, 131, 262, 0});
  bus.cameras[0].endings.push_back({bytes, 0});
  bench.poll();
  const std::vector<ImuSample> samples = bench.imu();
  REQUIRE(samples.size() == 1);
  CHECK(samples[0].t_us == zero_us + 500);
  CHECK(samples[0].accel_m_s2[0] == Approx(-9.80665 / 2));
  CHECK(samples[0].accel_m_s2[1] == Approx(-9.80665));
  CHECK(samples[0].accel_m_s2[2] == 0);
  CHECK(samples[0].gyro_rad_s[2] == Approx(262 / 131.072 * 3.14159265358979 / 180));
  CHECK(bench.source.counters().imu_pushed == 1);
}

TEST_CASE("USB: an IMU that nobody asked for stays out of its ring") {
  Usb bus;
  bus.cameras = {davis346()};
  Bench bench(bus);
  REQUIRE(bench.stream());
  bus.cameras[0].endings.push_back(first_time());
  Bytes bytes = inivation::stream({time_stamp(500)});
  append_imu(bytes, 0xE0, {1, 2, 3, 4, 5, 6, 7});
  bus.cameras[0].endings.push_back({bytes, 0});
  bench.poll(3);
  CHECK(bench.imu().empty());
  CHECK(bench.source.counters().inivation.imu_samples == 1);
}

TEST_CASE("USB: an EVK4 streams EVT3") {
  Usb bus;
  bus.cameras = {evk4()};
  Bench bench(bus);
  REQUIRE(bench.stream());
  using namespace evt_words::evt3;
  bus.cameras[0].endings.push_back({stream({time_high(5), time_low(0)}), ETIMEDOUT});
  bench.poll();
  const std::int64_t zero_us = bus.clock.now_us() - 5 * 4096;
  bus.cameras[0].endings.push_back({stream({time_low(7), addr_y(719), addr_x(1, 1279), addr_x(0, 1280)}), 0});
  bench.poll();
  CHECK(bench.events() == std::vector<Event>{{zero_us + 5 * 4096 + 7, 1279, 719, 1}});
  CHECK(bench.source.counters().evt.dropped_events == 1);
  CHECK(bench.source.counters().timed_out == 1);
}

TEST_CASE("USB: a full ring drops, and the transfers go on") {
  Usb bus;
  bus.cameras = {davis346()};
  Bench bench(bus);
  REQUIRE(bench.stream());
  bus.cameras[0].endings.push_back(first_time());
  Bytes bytes = inivation::stream({time_stamp(10), row(1)});
  for (int i = 0; i < 8000; ++i) evt_words::append(bytes, column(1, 5), 2);
  for (int i = 0; i < 3; ++i) bus.cameras[0].endings.push_back({bytes, 0});
  const std::size_t in_flight = bus.in_flight();
  bench.poll(4);
  CHECK(bench.rings.events.offered() == 24000);
  CHECK(bench.rings.events.dropped() == 24000 - (1 << 14));
  CHECK(bench.source.counters().events_pushed == 24000);
  CHECK(bus.in_flight() == in_flight);
}

TEST_CASE("USB: several transfers that end at once are taken in the order in which they were sent") {
  Usb bus;
  bus.cameras = {davis346()};
  bus.ends_per_wait = 5;
  Bench bench(bus);
  REQUIRE(bench.stream());
  bus.cameras[0].endings.push_back(first_time());
  bench.poll();
  for (unsigned i = 0; i < 40; ++i)
    bus.cameras[0].endings.push_back(words({time_stamp(10 + i), row(1), column(1, i)}));
  bench.poll(8);
  const std::vector<Event> events = bench.events();
  REQUIRE(events.size() == 40);
  for (std::size_t i = 0; i < events.size(); ++i) CHECK(events[i].x == i);
}

TEST_CASE("USB: what the camera itself dropped is read once a second") {
  Usb bus;
  bus.cameras = {davis346()};
  Bench bench(bus);
  REQUIRE(bench.stream());
  bus.cameras[0].registers[at(0, 83)] = 1;
  bus.cameras[0].registers[at(0, 84)] = 5;
  for (int i = 0; i < 50; ++i) {
    bus.cameras[0].endings.push_back(words({wrap(1)}));
    bench.poll(2);
  }
  CHECK(bench.source.counters().device_dropped == 0);
  for (int i = 0; i < 60; ++i) {
    bus.cameras[0].endings.push_back(words({wrap(1)}));
    bench.poll(2);
  }
  CHECK(bench.source.counters().device_dropped == 0x100000005);
  // A refusal changes nothing.
  bus.fail_control_after = 0;
  for (int i = 0; i < 120; ++i) {
    bus.cameras[0].endings.push_back(words({wrap(1)}));
    bench.poll(2);
  }
  CHECK(bench.source.counters().lost == 0);
  CHECK(bench.source.counters().device_dropped == 0x100000005);
}

TEST_CASE("USB: a counter of 64 bits that carries over while it is read is read again") {
  Usb bus;
  bus.cameras = {davis346()};
  Bench bench(bus);
  REQUIRE(bench.stream());
  bus.cameras[0].registers[at(0, 83)] = 0;
  bus.cameras[0].registers[at(0, 84)] = 0xfffffff0;
  bus.cameras[0].after_read = [](Camera& camera, std::uint32_t address) {
    if (address != at(0, 84) || camera.registers[at(0, 83)] == 1) return;
    camera.registers[at(0, 83)] = 1;
    camera.registers[at(0, 84)] = 3;
  };
  for (int i = 0; i < 110; ++i) {
    bus.cameras[0].endings.push_back(words({wrap(1)}));
    bench.poll(2);
  }
  CHECK(bench.source.counters().device_dropped == 0x100000003);
}

TEST_CASE("USB: polls are bounded while the camera is started and while it streams") {
  Usb bus;
  bus.cameras = {evk4()};
  Bench bench(bus);
  REQUIRE(bench.source.start().ok());
  std::int64_t longest_us = 0;
  for (int i = 0; i < 2000 && bench.phase() != UsbCameraPhase::kStreaming; ++i) {
    const std::int64_t before_us = bus.clock.now_us();
    bench.poll();
    longest_us = std::max(longest_us, bus.clock.now_us() - before_us);
  }
  CHECK(bench.phase() == UsbCameraPhase::kStreaming);
  CHECK(longest_us <= 10'000 + 20'000);  // reading old data away takes one time-out of 20 ms
  const std::int64_t before_us = bus.clock.now_us();
  bench.poll();
  CHECK(bus.clock.now_us() - before_us <= 10'000);
}

TEST_CASE("USB: the source behind the engine's functions") {
  Usb bus;
  bus.cameras = {davis346()};
  Bench bench(bus);
  const Source source = bench.source.source();
  CHECK(source.poll(source.self, bench.inlets, INT64_MAX, 10'000).status.code() == StatusCode::kBadState);
  REQUIRE(source.start(source.self).ok());
  for (int i = 0; i < 100; ++i) CHECK(source.poll(source.self, bench.inlets, INT64_MAX, 10'000).status.ok());
  CHECK(bench.phase() == UsbCameraPhase::kStreaming);
  source.stop(source.self);
  CHECK(bench.phase() == UsbCameraPhase::kClosed);
  CHECK(bus.all_closed());
}
