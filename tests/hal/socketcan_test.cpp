// The SocketCAN source against a scripted kernel: frames, stamps, filters.
#include "hal/socketcan_bench.hpp"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>

using namespace egofocus;
using test::ScriptedCan;

TEST_CASE("socketcan: three frames of a Bosch IMU become samples at the kernel's time") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  CHECK(bench.health().link == CanLink::kUp);
  for (const auto& [id, low, high] :
       {std::tuple{0x174u, 0xD0, 0x87}, {0x178u, 0x60, 0x70}, {0x17Cu, 0xE8, 0x83}}) {
    bench.kernel.frame(id, {low, high, 0, 0, 0, 0x80, 4, 0});
    bench.kernel.pass(300);
  }
  bench.kernel.pass(2000);  // until the thread came to read
  const Delivery delivery = bench.poll();
  CHECK(delivery.status.ok());
  CHECK_FALSE(delivery.ended);
  CHECK(delivery.watermark_us == 5'002'900 - 5000);  // now minus the group window
  const auto imu = bench.imu();
  REQUIRE(imu.size() == 2);
  CHECK(imu[0].t_us == 5'000'000);
  CHECK(imu[0].gyro_rad_s[2] == Approx(10 * kRadPerDeg));
  CHECK(bench.health().frames == 3);
  CHECK(bench.health().motion.samples == 2);
  CHECK(bench.health().without_stamp == 0);
}

TEST_CASE("socketcan: filters come from the DBC, parameter groups as such, and before bind") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  can_filter filters[3];
  const auto& bytes = bench.kernel.options.at(CAN_RAW_FILTER);
  REQUIRE(bytes.size() == sizeof filters);
  std::memcpy(filters, bytes.data(), sizeof filters);
  const canid_t kind = CAN_EFF_FLAG | CAN_RTR_FLAG;
  CHECK(filters[0].can_id == 0x174);
  CHECK(filters[0].can_mask == (0x7FF | kind));
  CHECK(filters[2].can_id == 0x17C);

  const auto dbc = read_dbc_text(
      "BO_ 2565876352 ARI: 8 X\n SG_ Y : 32|16@1+ (0.0078125,-250) [0|0] \"deg/s\" X\n"
      "BO_ 2364540158 Plain: 8 X\n SG_ V : 0|16@1+ (0.1,0) [0|0] \"\" X\n"
      "BO_ 2364473598 Addressed: 8 X\n SG_ W : 0|16@1+ (0.1,0) [0|0] \"\" X\n"
      "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\";\n"
      "BA_DEF_DEF_ \"VFrameFormat\" \"ExtendedCAN\";\n"
      "BA_ \"VFrameFormat\" BO_ 2565876352 3;\nBA_ \"VFrameFormat\" BO_ 2364473598 3;\n");
  CanBench j1939(
      {},
      config_of({entry("ARI", "Y", CanRole::kGyroZ, CanUnit::kDegPerSecond),
                 entry("Plain", "V", CanRole::kVelocityX), entry("Addressed", "W", CanRole::kWheelSpeed)}),
      *dbc);
  REQUIRE(j1939.source.start().ok());
  std::memcpy(filters, j1939.kernel.options.at(CAN_RAW_FILTER).data(), sizeof filters);
  CHECK(filters[0].can_id == (0x18F02A80 | CAN_EFF_FLAG));
  CHECK(filters[0].can_mask == (0x03FFFF00 | kind));
  CHECK(filters[1].can_id == (0x0CF004FE | CAN_EFF_FLAG));
  CHECK(filters[1].can_mask == (0x1FFFFFFF | kind));
  CHECK(filters[2].can_id == (0x0CEF00FE | CAN_EFF_FLAG));
  CHECK(filters[2].can_mask == (0x03FF0000 | kind));
  // Another priority and source address of the group, and not of a plain id.
  j1939.kernel.frame(0x0CF02A17 | CAN_EFF_FLAG, {0, 0x7D, 0, 0x7D, 0x80, 0x7C, 0, 0});
  j1939.kernel.frame(0x0CF004FF | CAN_EFF_FLAG, {1, 0, 0, 0, 0, 0, 0, 0});
  j1939.poll();
  CHECK(j1939.imu().size() == 1);
  CHECK(j1939.health().motion.frames_unknown == 1);
}

TEST_CASE("socketcan: CAN FD, error, remote and malformed messages are told apart and counted") {
  const auto dbc = read_dbc_text("BO_ 7 Wide: 64 X\n SG_ W : 504|8@1- (1,0) [0|0] \"\" X\n");
  CanBench bench({}, config_of({entry("Wide", "W", CanRole::kGyroX)}), *dbc);
  REQUIRE(bench.source.start().ok());
  test::Scripted& wide = bench.kernel.frame(7, {});
  wide.bytes = CANFD_MTU;
  wide.frame.len = 64;
  wide.frame.data[63] = 0x80;
  bench.kernel.frame(7 | CAN_RTR_FLAG, {});
  bench.kernel.error_frame(CAN_ERR_PROT, {0, 0, 0, 0, 0, 0, 0, 0});
  bench.kernel.frame(7, {1}).bytes = 15;
  bench.kernel.frame(7, {1}).frame.len = 9;
  test::Scripted& over = bench.kernel.frame(7, {1});
  over.bytes = CANFD_MTU;
  over.frame.len = 65;
  bench.kernel.frame(7, {1}).truncated = true;
  bench.poll();
  const auto imu = bench.imu();
  REQUIRE(imu.size() == 1);
  CHECK(imu[0].gyro_rad_s[0] == -128);
  CHECK(bench.health().frames == 1);
  CHECK(bench.health().remote_frames == 1);
  CHECK(bench.health().errors.frames == 1);
  CHECK(bench.health().errors.protocol == 1);
  CHECK(bench.health().malformed == 4);
}

TEST_CASE("socketcan: what the socket's queue lost is counted, over the wrap of its counter, per socket") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  bench.kernel.frame(0x174, {0, 0x80, 0, 0, 0, 0x80, 0, 0});
  bench.kernel.frame(0x174, {0, 0x80, 0, 0, 0, 0x80, 1, 0}).drops = 1994;
  bench.kernel.frame(0x174, {0, 0x80, 0, 0, 0, 0x80, 1, 0}).drops = 1994;
  bench.poll();
  CHECK(bench.health().kernel_dropped == 1994);
  bench.kernel.frame(0x174, {0, 0x80, 0, 0, 0, 0x80, 1, 0}).drops = 0xFFFFFFF0;
  bench.kernel.frame(0x174, {0, 0x80, 0, 0, 0, 0x80, 1, 0}).drops = 4;
  bench.poll();
  CHECK(bench.health().kernel_dropped == 0x100000004);
  bench.kernel.fail(ENODEV);
  bench.poll();
  bench.kernel.pass(200000);
  bench.poll();  // a new socket
  bench.kernel.frame(0x174, {0, 0x80, 0, 0, 0, 0x80, 1, 0}).drops = 6;
  bench.poll();
  CHECK(bench.health().kernel_dropped == 0x10000000A);
}

TEST_CASE("socketcan: a frame without a stamp, or with one that cannot be, gets the time of reading") {
  const auto dbc = read_dbc_text("BO_ 7 R: 1 X\n SG_ R : 0|8@1- (1,0) [0|0] \"\" X\n");
  CanBench bench({}, config_of({entry("R", "R", CanRole::kGyroX)}), *dbc);
  REQUIRE(bench.source.start().ok());
  bench.kernel.frame(7, {1}).software_ns = 0;
  bench.kernel.frame(7, {2}).software_ns += 3'600'000'000'000;  // CLOCK_REALTIME was set back since
  bench.kernel.frame(7, {3}).software_ns -= 3'600'000'000'000;
  bench.kernel.frame(7, {4}).software_ns -= 700'000;
  bench.poll();
  const auto imu = bench.imu();
  REQUIRE(imu.size() == 4);
  for (int i = 0; i < 3; ++i) CHECK(imu[static_cast<std::size_t>(i)].t_us == 5'000'000);
  CHECK(imu[3].t_us == 4'999'300);
  CHECK(bench.health().without_stamp == 3);

  // The same after the clock was set: the relation is measured at each reading.
  bench.kernel.realtime_ns += 7'200'000'000'000;
  bench.kernel.frame(7, {5}).software_ns -= 400'000;
  bench.poll();
  const auto later = bench.imu();
  REQUIRE(later.size() == 1);
  CHECK(later[0].t_us == 4'999'600);
}

TEST_CASE("socketcan: the controller's stamps are mapped; without them the kernel's count") {
  const auto dbc = read_dbc_text("BO_ 7 R: 1 X\n SG_ R : 0|8@1- (1,0) [0|0] \"\" X\n");
  for (const bool hardware : {true, false}) {
    SocketCanConfig config;
    config.hardware_time = hardware;
    CanBench bench(config, config_of({entry("R", "R", CanRole::kGyroX)}), *dbc);
    REQUIRE(bench.source.start().ok());
    int flags = 0;
    std::memcpy(&flags, bench.kernel.options.at(SO_TIMESTAMPING).data(), sizeof flags);
    CHECK(((flags & SOF_TIMESTAMPING_RAW_HARDWARE) != 0) == hardware);
    std::int64_t worst_us = 0;
    for (int i = 0; i < 2000; ++i) {
      const std::int64_t truth_us = bench.kernel.monotonic_ns / 1000;
      const std::int64_t delay_us = (i * 7919) % 3000;  // a USB adapter's
      bench.kernel.pass(delay_us);
      bench.kernel.frame(7, {1}).hardware_ns =
          1'790'000'000'000'000'000 + i * 5'000'000LL;  // as gs_usb: since 1970
      bench.poll();
      const auto imu = bench.imu();
      REQUIRE(imu.size() == 1);
      if (i > 1000) worst_us = std::max<std::int64_t>(worst_us, std::llabs(imu[0].t_us - truth_us));
      bench.kernel.pass(5000 - delay_us);
    }
    INFO("worst error " << worst_us << " us");
    CHECK((worst_us < 300) == hardware);
    CHECK(bench.health().hardware_stamps == (hardware ? 2000u : 0u));
    CHECK(bench.health().clock.used == (hardware ? 2000u : 0u));
    CHECK(bench.health().clock.invalid == 0);
  }
}

TEST_CASE("socketcan: with device_time samples keep the controller's, and what has none is dropped") {
  const auto dbc = read_dbc_text("BO_ 7 R: 1 X\n SG_ R : 0|8@1- (1,0) [0|0] \"\" X\n");
  SocketCanConfig config;
  config.hardware_time = false;
  config.device_time = true;
  CanMotionConfig motion = config_of({entry("R", "R", CanRole::kGyroX)});
  motion.group_window_us = 2000;
  CanBench bench(config, motion, *dbc);
  REQUIRE(bench.source.start().ok());
  int flags = 0;
  std::memcpy(&flags, bench.kernel.options.at(SO_TIMESTAMPING).data(), sizeof flags);
  CHECK((flags & SOF_TIMESTAMPING_RAW_HARDWARE) != 0);
  CHECK(bench.poll().watermark_us == INT64_MIN);
  bench.kernel.frame(7, {1}).hardware_ns = 40'000'700;
  bench.kernel.frame(7, {2});
  bench.kernel.frame(7, {3}).hardware_ns = 45'000'000;
  CHECK(bench.poll().watermark_us == 45'000 - 2000 - 1);
  const auto imu = bench.imu();
  REQUIRE(imu.size() == 2);
  CHECK(imu[0].t_us == 40'000);
  CHECK(imu[1].t_us == 45'000);
  CHECK(bench.health().without_stamp == 1);
  bench.kernel.pass(1'000'000);
  CHECK(bench.poll().watermark_us == 45'000 - 2000 - 1);
}

TEST_CASE("socketcan: more than one batch a poll, and never more than a bound") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  for (int i = 0; i < 300; ++i) bench.kernel.frame(0x174, {0, 0x80, 0, 0, 0, 0x80, 0, 0});
  bench.poll();
  CHECK(bench.health().frames == 256);
  bench.poll();
  CHECK(bench.health().frames == 300);
}

TEST_CASE("socketcan: a tap sees the frames that are used, with their times") {
  std::vector<CanFrame> frames;
  const CanTap tap{&frames, [](void* self, const CanFrame& frame) noexcept {
                     static_cast<std::vector<CanFrame>*>(self)->push_back(frame);
                   }};
  CanBench bench({}, bosch(), *read_shipped_dbc("bosch_mm.dbc"), tap);
  REQUIRE(bench.source.start().ok());
  for (int i = 0; i < 10; ++i) bench.kernel.frame(0x174, {i, 0x80, 0, 0, 0, 0x80, 0, 0});
  bench.poll();
  REQUIRE(frames.size() == 10);
  CHECK(frames[7].id == 0x174);
  CHECK(frames[7].data[0] == 7);
  CHECK(frames[7].t_us == 5'000'000);
  CHECK(bench.health().frames == 10);
}
