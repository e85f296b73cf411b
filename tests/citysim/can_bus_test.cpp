#include "citysim/can_bus.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <stdexcept>

#include "citysim/robots.hpp"
#include "hal/candump_decoder.hpp"

using namespace egofocus;
using namespace egofocus::citysim;
using namespace egofocus::citysim::test;

TEST_CASE("the wire carries one frame at a time, the lowest id first") {
  const auto frame = [](std::int64_t t_us, std::uint32_t id, bool extended, int length) {
    CanFrame f;
    f.t_us = t_us;
    f.id = id;
    f.extended = extended;
    f.length = static_cast<std::uint8_t>(length);
    return f;
  };
  std::int64_t busy_us = 0;
  const std::vector<CanFrame> wire = arbitrated(
      {frame(1000, 0x300, false, 8), frame(1001, 0x2AA, false, 8), frame(1001, 0x0AA80001, true, 8),
       frame(1001, 0x0AA40001, true, 8), frame(1002, 0x100, false, 1), frame(9000, 0x7FF, false, 0)},
      500000, busy_us);
  REQUIRE(wire.size() == 6);
  CHECK(wire[0].id == 0x300);  // alone when it began
  CHECK(wire[1].id == 0x100);
  CHECK(wire[2].id == 0x0AA40001);  // its first 11 bits are 0x2A9
  CHECK(wire[3].id == 0x2AA);
  CHECK(wire[4].id == 0x0AA80001);  // the same first 11 bits: the short id wins
  CHECK(wire[5].id == 0x7FF);
  CHECK(wire[0].t_us >= 1220);  // an 8-byte frame at 500 kbit/s takes 0.22 to 0.27 ms
  CHECK(wire[0].t_us <= 1270);
  CHECK(wire[5].t_us == 9000 + frame_time_us(wire[5], 500000));
  std::int64_t sum_us = 0;
  for (const CanFrame& f : wire) sum_us += frame_time_us(f, 500000);
  CHECK(busy_us == sum_us);

  const MotionBus bus = motion_bus(move(Robot::kCar, 20, 1), BusRobot::kCar,
                                   draw_bus_faults(BusRobot::kCar, 1), camera_of(Robot::kCar), 1);
  for (std::size_t i = 1; i < bus.frames.size(); ++i) {
    REQUIRE(bus.frames[i].t_us - bus.frames[i - 1].t_us >= frame_time_us(bus.frames[i], 500000));
  }
}

TEST_CASE("the same seed gives the same log, and the log gives back the frames") {
  const auto log = [](std::uint64_t seed) {
    return candump_text(motion_bus(move(Robot::kDrone, 5, 1), BusRobot::kDrone,
                                   draw_bus_faults(BusRobot::kDrone, 1), {}, seed)
                            .frames);
  };
  CHECK(log(1) == log(1));
  CHECK(log(1) != log(2));
  const MotionBus bus = motion_bus(move(Robot::kDrone, 5, 1), BusRobot::kDrone, {}, {}, 1);
  const std::string text = candump_text(bus.frames);
  std::vector<CanFrame> back(bus.frames.size() + 1);
  CandumpDecoder decoder;
  REQUIRE(decoder.feed(std::as_bytes(std::span(text)), back).produced == bus.frames.size());
  for (std::size_t i = 0; i < bus.frames.size(); ++i) {
    REQUIRE(back[i].t_us == bus.frames[i].t_us);
    REQUIRE(back[i].id == bus.frames[i].id);
    REQUIRE(std::equal(back[i].data, back[i].data + 8, bus.frames[i].data));
  }
  BusFaults wrong;
  wrong.jitter_us = -1;
  CHECK_THROWS_AS(motion_bus(move(Robot::kDrone, 5, 1), BusRobot::kDrone, wrong, {}, 1),
                  std::invalid_argument);
}
