#include "hal/can_bench.hpp"
#include "hal/dbc_files.hpp"

using namespace egofocus;

TEST_CASE("can: Bosch, a lost frame costs its sample alone") {
  Bench bench(bosch(), *read_shipped_dbc("bosch_mm.dbc"));
  bench.feed(tx1(0, 0));
  bench.feed(tx3(600, 0));  // TX2 lost
  bench.feed(tx1(10000, 1));
  bench.feed(tx2(10300, 1));
  bench.feed(tx3(10600, 1));
  CHECK(bench.imu.size() == 2);
  CHECK(bench.n().samples_incomplete == 2);  // gyro and accelerometer
  CHECK(bench.imu[0].t_us == 10000);
}

TEST_CASE("can: Bosch, frames of other counters do not mix, nor late ones") {
  Bench bench(bosch(), *read_shipped_dbc("bosch_mm.dbc"));
  bench.feed(tx1(0, 0));
  bench.feed(tx2(300, 1));
  bench.feed(tx3(600, 1));
  CHECK(bench.imu.empty());
  CHECK(bench.n().samples_incomplete == 2);
  bench.feed(tx1(900, 1));  // any order
  CHECK(bench.imu.size() == 2);
  bench.feed(tx1(20000, 2));
  bench.feed(tx2(25001, 2));  // beyond the window of 5 ms
  bench.feed(tx3(25200, 2));
  CHECK(bench.imu.size() == 2);
  CHECK(bench.n().samples_incomplete == 4);
}

TEST_CASE("can: multiplexed axes and the velocity's covariance") {
  const auto dbc = read_dbc_text(
      "BO_ 7 Imu: 3 X\n SG_ Mux M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ X m0 : 8|16@1- (0.5,0) [0|0] \"\" X\n"
      " SG_ Y m1 : 8|16@1- (0.5,0) [0|0] \"\" X\n SG_ Z m2 : 8|16@1- (0.5,0) [0|0] \"\" X\n"
      "BO_ 8 Vel: 8 X\n SG_ Vx : 0|8@1- (1,0) [0|0] \"\" X\n SG_ Vy : 8|8@1- (1,0) [0|0] \"\" X\n"
      " SG_ Vz : 16|8@1- (1,0) [0|0] \"\" X\n SG_ Xx : 24|8@1+ (0.01,0) [0|0] \"\" X\n SG_ Yz : 32|8@1- "
      "(0.01,0) [0|0] \"\" X\n");
  Bench bench(config_of({entry("Imu", "X", CanRole::kGyroX), entry("Imu", "Y", CanRole::kGyroY),
                         entry("Imu", "Z", CanRole::kGyroZ), entry("Vel", "Vx", CanRole::kVelocityX),
                         entry("Vel", "Vy", CanRole::kVelocityY), entry("Vel", "Vz", CanRole::kVelocityZ),
                         entry("Vel", "Xx", CanRole::kVarianceXx), entry("Vel", "Yz", CanRole::kVarianceYz)}),
              *dbc);
  bench.feed(frame(1, 7, {0, 2, 0}));
  bench.feed(frame(2, 7, {1, 4, 0}));
  bench.feed(frame(3, 7, {3, 9, 0}));
  CHECK(bench.imu.empty());
  bench.feed(frame(4, 7, {2, 0xFA, 0xFF}));
  REQUIRE(bench.imu.size() == 1);
  CHECK(bench.imu[0].gyro_rad_s[0] == 1.0);
  CHECK(bench.imu[0].gyro_rad_s[1] == 2.0);
  CHECK(bench.imu[0].gyro_rad_s[2] == -3.0);
  bench.feed(frame(5, 8, {1, 2, 0xFD, 4, 0xFB}));
  REQUIRE(bench.odometry.size() == 1);
  CHECK(bench.odometry[0].velocity_m_s[2] == -3.0);
  CHECK(bench.odometry[0].covariance_m2_s2[0] == Approx(0.04));
  CHECK(bench.odometry[0].covariance_m2_s2[4] == Approx(-0.05));
  CHECK(bench.odometry[0].covariance_m2_s2[3] == 0.0);
}

TEST_CASE("can: what cannot be meant is refused") {
  const auto dbc = read_shipped_dbc("wheels_examples.dbc");
  const auto code_of = [&](const CanMotionConfig& config, std::int64_t* value = nullptr) {
    CanMotionDecoder decoder;
    const Status status = decoder.configure(config, *dbc);
    if (value != nullptr) *value = status.value();
    MotionSamples out;
    if (!status.ok()) {
      decoder.feed(frame(1, 0xAA, {0, 0, 0, 0, 0, 0, 0, 0}), out);
      CHECK(decoder.counters().frames_unknown == 1);
    }
    return status.code();
  };
  const CanSignalRole good = entry("ToyotaWheels", "ToyotaFr", CanRole::kWheelSpeed);
  std::int64_t index = -1;
  CHECK(code_of(config_of({good})) == StatusCode::kOk);
  CHECK(code_of(config_of({})) == StatusCode::kBadMotion);
  CHECK(code_of(config_of({good, entry("ToyotaWheels", "Nothing", CanRole::kWheelSpeed)}), &index) ==
        StatusCode::kMissingSignal);
  CHECK(index == 1);
  CHECK(code_of(config_of({good, entry("Nothing", "ToyotaFr", CanRole::kWheelSpeed)}), &index) ==
        StatusCode::kMissingSignal);
  CHECK(index == 1);
  const CanSignalRole gyro = entry("ToyotaWheels", "ToyotaFr", CanRole::kGyroX);
  CHECK(code_of(config_of({gyro, gyro})) == StatusCode::kBadMotion);
  CHECK(code_of(config_of({entry("ToyotaWheels", "ToyotaFr", CanRole::kGyroX, CanUnit::kSi, 0)})) ==
        StatusCode::kBadMotion);
  CHECK(code_of(config_of({entry("ToyotaWheels", "ToyotaFr", CanRole::kVarianceXx)})) ==
        StatusCode::kBadMotion);
  CHECK(code_of(config_of({entry("ToyotaWheels", "ToyotaFr", static_cast<CanRole>(17))})) ==
        StatusCode::kBadMotion);
  CanMotionConfig config = config_of({good});
  config.gyro_axes = {{1, 1, 3}};
  CHECK(code_of(config) == StatusCode::kBadMotion);
  config = config_of({good});
  config.accel_axes = {{0, 2, 3}};
  CHECK(code_of(config) == StatusCode::kBadMotion);
  config = config_of({good});
  config.group_window_us = -1;
  CHECK(code_of(config) == StatusCode::kBadMotion);
  config = config_of({good});
  config.signal_count = 33;
  CHECK(code_of(config) == StatusCode::kBadMotion);
  config.signal_count = 17;
  for (std::size_t i = 0; i < 17; ++i) config.signals[i] = good;
  CHECK(code_of(config) == StatusCode::kBadMotion);
}

TEST_CASE("can: names of roles and units") {
  for (std::size_t i = 0; i < kCanRoles; ++i) {
    CanRole role = CanRole::kCounter;
    REQUIRE(can_role_of(to_string(static_cast<CanRole>(i)), role));
    CHECK(role == static_cast<CanRole>(i));
  }
  CanRole role{};
  CanUnit unit{};
  CHECK_FALSE(can_role_of("gyro", role));
  CHECK(can_unit_of("km/h", unit));
  CHECK(unit == CanUnit::kKmPerHour);
  CHECK_FALSE(can_unit_of("mph", unit));
}

TEST_CASE("can: a frame written through the DBC comes back as the sample") {
  const auto dbc = read_shipped_dbc("xsens_mti.dbc");
  const DbcMessage* message = dbc->find_message("RateOfTurn");
  CanFrame f = frame(77, message->id, {});
  f.length = message->length;
  const double values[3] = {0.25, -0.125, 1.5};
  const char* names[3] = {"GyrX", "GyrY", "GyrZ"};
  for (int i = 0; i < 3; ++i) {
    REQUIRE(encode_signal(*dbc->find_signal(*message, names[i]), values[i], std::span(f.data, f.length)));
  }
  Bench bench(
      config_of({entry("RateOfTurn", "GyrX", CanRole::kGyroX), entry("RateOfTurn", "GyrY", CanRole::kGyroY),
                 entry("RateOfTurn", "GyrZ", CanRole::kGyroZ)}),
      *dbc);
  bench.feed(f);
  REQUIRE(bench.imu.size() == 1);
  for (int i = 0; i < 3; ++i) CHECK(bench.imu[0].gyro_rad_s[i] == values[i]);
}
