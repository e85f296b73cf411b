// Frames of real sensor layouts, made by hand from their descriptions.
#include "hal/can_bench.hpp"
#include "hal/dbc_files.hpp"

using namespace egofocus;

TEST_CASE("can: Bosch MM7.10, three frames make a sample") {
  Bench bench(bosch(), *read_shipped_dbc("bosch_mm.dbc"));
  bench.feed(tx1(1000, 4));
  bench.feed(tx2(1300, 4));
  CHECK(bench.imu.empty());
  bench.feed(tx3(1600, 4));
  REQUIRE(bench.imu.size() == 2);
  const ImuSample& gyro = bench.imu[0];
  CHECK(gyro.t_us == 1000);
  CHECK(gyro.has_gyro);
  CHECK_FALSE(gyro.has_accel);
  CHECK(gyro.gyro_rad_s[0] == Approx(20 * kRadPerDeg).epsilon(1e-12));  // sign -1
  CHECK(gyro.gyro_rad_s[1] == Approx(5 * kRadPerDeg).epsilon(1e-12));
  CHECK(gyro.gyro_rad_s[2] == Approx(10 * kRadPerDeg).epsilon(1e-12));
  const ImuSample& accel = bench.imu[1];
  CHECK(accel.t_us == 1000);
  CHECK(accel.has_accel);
  CHECK_FALSE(accel.has_gyro);
  CHECK(accel.accel_m_s2[0] == Approx(-0.2 * kG).margin(2e-3));
  CHECK(accel.accel_m_s2[1] == Approx(0.1 * kG).margin(2e-3));
  CHECK(accel.accel_m_s2[2] == Approx(1.0 * kG).margin(2e-3));
  CHECK(bench.n().frames_used == 3);
  CHECK(bench.n().samples == 2);
}

TEST_CASE("can: Bosch MM5.10 has no pitch rate: the axis is 0") {
  CanMotionConfig config = config_of({entry("MM_TX1", "YawRate", CanRole::kGyroZ, CanUnit::kDegPerSecond),
                                      entry("MM_TX2", "RollRate", CanRole::kGyroX, CanUnit::kDegPerSecond)});
  config.stamp_last_frame = true;
  config.imu_delay_us = 200;
  Bench bench(config, *read_shipped_dbc("bosch_mm.dbc"));
  bench.feed(tx1(1000, 0));
  bench.feed(tx3(1100, 0));
  bench.feed(tx2(1500, 0));
  REQUIRE(bench.imu.size() == 1);
  CHECK(bench.imu[0].t_us == 1300);
  CHECK(bench.imu[0].gyro_rad_s[1] == 0.0);
  CHECK(bench.n().frames_unknown == 1);
}

TEST_CASE("can: J1939 rates and accelerations, not-available values, any source address") {
  CanMotionConfig config = config_of({entry("ARI", "PitchRate", CanRole::kGyroY, CanUnit::kDegPerSecond),
                                      entry("ARI", "RollRate", CanRole::kGyroX, CanUnit::kDegPerSecond),
                                      entry("ARI", "YawRate", CanRole::kGyroZ, CanUnit::kDegPerSecond),
                                      entry("ACCS", "LateralAccel", CanRole::kAccelY),
                                      entry("ACCS", "LongitudinalAccel", CanRole::kAccelX),
                                      entry("ACCS", "VerticalAccel", CanRole::kAccelZ)});
  for (std::size_t i = 0; i < config.signal_count; ++i) config.signals[i].raw_max = 0xFAFF;
  const auto dbc = read_shipped_dbc("j1939_imu.dbc");
  const CanFrame ari =
      frame(500, 0x18F02A80, {0x00, 0x82, 0x00, 0x7D, 0x80, 0x7C, 0, 0}, true);  // 10, 0, -1 deg/s
  const CanFrame accs =
      frame(900, 0x18F02D80, {0x64, 0x7D, 0x00, 0x7D, 0xD5, 0x80, 0, 0}, true);  // 1, 0, 9.81
  Bench bench(config, *dbc);
  bench.feed(ari);
  bench.feed(accs);
  REQUIRE(bench.imu.size() == 2);
  CHECK(bench.imu[0].gyro_rad_s[0] == 0.0);
  CHECK(bench.imu[0].gyro_rad_s[1] == Approx(10 * kRadPerDeg));
  CHECK(bench.imu[0].gyro_rad_s[2] == Approx(-1 * kRadPerDeg));
  CHECK(bench.imu[1].t_us == 900);
  CHECK(bench.imu[1].accel_m_s2[0] == Approx(0.0).margin(1e-9));
  CHECK(bench.imu[1].accel_m_s2[1] == Approx(1.0));
  CHECK(bench.imu[1].accel_m_s2[2] == Approx(9.81));

  CanFrame bad = ari;
  bad.data[2] = 0xFF;
  bad.data[3] = 0xFF;
  bench.feed(bad);
  bad.data[2] = 0x00;
  bad.data[3] = 0xFB;  // the first value beyond
  bench.feed(bad);
  CHECK(bench.imu.size() == 2);
  CHECK(bench.n().invalid_values == 2);
  CHECK(bench.n().samples_invalid == 2);
  bad.data[2] = 0xFF;
  bad.data[3] = 0xFA;  // the last value within
  bench.feed(bad);
  CHECK(bench.imu.size() == 3);

  CanFrame other = ari;
  other.id = 0x0CF02A17;
  bench.feed(other);  // VFrameFormat in the file: the whole parameter group
  CHECK(bench.imu.size() == 4);
  CanFrame neighbour = ari;
  neighbour.id = 0x18F02B80;
  bench.feed(neighbour);
  CanFrame standard = ari;
  standard.extended = false;
  bench.feed(standard);
  CHECK(bench.n().frames_unknown == 2);

  for (std::size_t i = 0; i < dbc->message_count; ++i) dbc->messages[i].parameter_group = false;
  Bench exact(config, *dbc);
  exact.feed(other);
  CHECK(exact.n().frames_unknown == 1);
  config.match_parameter_group = true;
  Bench any(config, *dbc);
  any.feed(other);
  CHECK(any.imu.size() == 1);
}

TEST_CASE("can: Xsens, big-endian words, velocity with covariance defaults, axis map") {
  CanMotionConfig config = config_of(
      {entry("RateOfTurn", "GyrX", CanRole::kGyroX), entry("RateOfTurn", "GyrY", CanRole::kGyroY),
       entry("RateOfTurn", "GyrZ", CanRole::kGyroZ), entry("Acceleration", "AccX", CanRole::kAccelX),
       entry("Acceleration", "AccY", CanRole::kAccelY), entry("Acceleration", "AccZ", CanRole::kAccelZ),
       entry("Velocity", "VelX", CanRole::kVelocityX), entry("Velocity", "VelY", CanRole::kVelocityY),
       entry("Velocity", "VelZ", CanRole::kVelocityZ)});
  config.gyro_axes = {{2, -1, 3}};    // body x <- sensor y, body y <- minus sensor x
  config.accel_axes = {{1, -2, -3}};  // FRD -> FLU
  Bench bench(config, *read_shipped_dbc("xsens_mti.dbc"));
  bench.feed(frame(1, 0x32, {0x02, 0x00, 0xFE, 0x00, 0x00, 0x01}));  // 1, -1, 2^-9 rad/s
  bench.feed(frame(2, 0x34, {0x00, 0x80, 0x01, 0x00, 0xF6, 0x31}));  // 0.5, 1, -9.80859375 m/s^2
  bench.feed(frame(3, 0x76, {0x00, 0x40, 0xFF, 0xC0, 0x00, 0x00}));  // 1, -1, 0 m/s
  REQUIRE(bench.imu.size() == 2);
  CHECK(bench.imu[0].gyro_rad_s[0] == -1.0);
  CHECK(bench.imu[0].gyro_rad_s[1] == -1.0);
  CHECK(bench.imu[0].gyro_rad_s[2] == 1.0 / 512);
  CHECK(bench.imu[1].accel_m_s2[0] == 0.5);
  CHECK(bench.imu[1].accel_m_s2[1] == -1.0);
  CHECK(bench.imu[1].accel_m_s2[2] == 9.80859375);
  REQUIRE(bench.odometry.size() == 1);
  CHECK(bench.odometry[0].kind == OdometrySample::Kind::kBodyVelocity);
  CHECK(bench.odometry[0].velocity_m_s[0] == 1.0);
  CHECK(bench.odometry[0].velocity_m_s[1] == -1.0);
  CHECK(bench.odometry[0].covariance_m2_s2[0] == 0.0);
}

TEST_CASE("can: Racelogic IMU03, float32, axes spread over four ids") {
  constexpr auto kDeg = CanUnit::kDegPerSecond;
  constexpr auto kGs = CanUnit::kStandardGravity;
  const CanMotionConfig config = config_of({entry("IMU03_1", "Yaw_Rate", CanRole::kGyroZ, kDeg),
                                            entry("IMU03_3", "Pitch_Rate", CanRole::kGyroY, kDeg),
                                            entry("IMU03_3", "Roll_Rate", CanRole::kGyroX, kDeg),
                                            entry("IMU03_1", "X_Accel", CanRole::kAccelX, kGs),
                                            entry("IMU03_2", "Y_Accel", CanRole::kAccelY, kGs),
                                            entry("IMU03_4", "Z_Accel", CanRole::kAccelZ, kGs)});
  Bench bench(config, *read_shipped_dbc("racelogic_imu03.dbc"));
  bench.feed(frame(10, 0x600, {0x41, 0x20, 0, 0, 0x3F, 0x00, 0, 0}));  // 10 deg/s, 0.5 g
  bench.feed(frame(20, 0x601, {0xBE, 0x80, 0, 0, 0x41, 0xC8, 0, 0}));  // -0.25 g, 25 deg C
  bench.feed(frame(30, 0x602, {0xC0, 0x00, 0, 0, 0x3F, 0x80, 0, 0}));  // -2, 1 deg/s
  REQUIRE(bench.imu.size() == 1);
  CHECK(bench.imu[0].t_us == 10);
  CHECK(bench.imu[0].gyro_rad_s[0] == Approx(1 * kRadPerDeg));
  CHECK(bench.imu[0].gyro_rad_s[1] == Approx(-2 * kRadPerDeg));
  CHECK(bench.imu[0].gyro_rad_s[2] == Approx(10 * kRadPerDeg));
  bench.feed(frame(40, 0x603, {0x3F, 0x80, 0, 0, 0, 0, 0, 0}));
  REQUIRE(bench.imu.size() == 2);
  CHECK(bench.imu[1].accel_m_s2[0] == Approx(0.5 * kG));
  CHECK(bench.imu[1].accel_m_s2[1] == Approx(-0.25 * kG));
  CHECK(bench.imu[1].accel_m_s2[2] == Approx(1 * kG));

  bench.feed(frame(10010, 0x600, {0x7F, 0xC0, 0, 0, 0x3F, 0x00, 0, 0}));  // NaN
  bench.feed(frame(10020, 0x602, {0xC0, 0x00, 0, 0, 0x7F, 0x80, 0, 0}));  // infinity
  CHECK(bench.imu.size() == 2);
  CHECK(bench.n().invalid_values == 2);
  CHECK(bench.n().samples_invalid == 1);
}

TEST_CASE("can: wheel speeds of several makers, averaged") {
  const auto dbc = read_shipped_dbc("wheels_examples.dbc");
  const auto speed = [&](const std::string& message, std::initializer_list<const char*> signals, CanUnit unit,
                         const CanFrame& f) {
    CanMotionConfig config;
    for (const char* s : signals)
      config.signals[config.signal_count++] = entry(message, s, CanRole::kWheelSpeed, unit);
    Bench bench(config, *dbc);
    bench.feed(f);
    REQUIRE(bench.odometry.size() == 1);
    CHECK(bench.odometry[0].kind == OdometrySample::Kind::kWheelSpeed);
    return bench.odometry[0].velocity_m_s[0];
  };
  // 0x1A6F = 6767: standstill; 0x1A6F + 3600 = 0x287F: 36 km/h.
  CHECK(speed("ToyotaWheels", {"ToyotaFr", "ToyotaFl", "ToyotaRr", "ToyotaRl"}, CanUnit::kKmPerHour,
              frame(1, 0xAA, {0x1A, 0x6F, 0x1A, 0x6F, 0x1A, 0x6F, 0x1A, 0x6F})) == Approx(0.0).margin(1e-12));
  CHECK(speed("ToyotaWheels", {"ToyotaRr", "ToyotaRl"}, CanUnit::kKmPerHour,
              frame(1, 0xAA, {0x1A, 0x6F, 0x1A, 0x6F, 0x28, 0x7F, 0x28, 0x7F})) == Approx(10.0));
  // 15 bits each, one after the other from the top bit: 3600, 7200, 10800, 14400 -> mean 9000 = 90 km/h.
  // 001110000100000 001110000100000|0 ... packed by hand into 60 bits.
  CHECK(speed("HondaWheels", {"HondaFl", "HondaFr", "HondaRl", "HondaRr"}, CanUnit::kKmPerHour,
              frame(1, 0x1D0, {0x1C, 0x20, 0x70, 0x81, 0x51, 0x83, 0x84, 0x00})) == Approx(25.0));
  // 14 bits at each 16: 1152 * 0.03125 = 36 km/h; the two bits above are someone else's.
  CHECK(speed("HyundaiWheels", {"HyundaiFl", "HyundaiFr", "HyundaiRl", "HyundaiRr"}, CanUnit::kKmPerHour,
              frame(1, 0x386, {0x80, 0xC4, 0x80, 0x84, 0x80, 0x44, 0x80, 0x04})) == Approx(10.0));
  CHECK(speed("BmwWheels", {"BmwFl", "BmwRr"}, CanUnit::kKmPerHour,
              frame(1, 0xCE, {0x40, 0x02, 0, 0, 0, 0, 0xC0, 0xFD})) == Approx(0.0).margin(1e-12));
}

TEST_CASE("can: wheels over two frames, yaw rate of a Toyota, signal in a CAN FD frame") {
  const auto dbc = read_shipped_dbc("wheels_examples.dbc");
  Bench gm(config_of({entry("GmWheelsFront", "GmFl", CanRole::kWheelSpeed),
                      entry("GmWheelsRear", "GmRl", CanRole::kWheelSpeed)}),
           *dbc);
  gm.feed(frame(100, 0x348, {0x00, 0x64, 0, 0, 0}));
  gm.feed(frame(200, 0x34A, {0x00, 0xC8, 0, 0, 0}));
  REQUIRE(gm.odometry.size() == 1);
  CHECK(gm.odometry[0].t_us == 100);
  CHECK(gm.odometry[0].velocity_m_s[0] == Approx(150 * 0.0311));

  Bench toyota(
      config_of({entry("ToyotaKinematics", "ToyotaYawRate", CanRole::kGyroZ, CanUnit::kDegPerSecond)}), *dbc);
  toyota.feed(frame(1, 0x24, {0xFE, 0x64, 0, 0, 0, 0, 0, 0}));  // 10 bits: 0x264 = 612
  REQUIRE(toyota.imu.size() == 1);
  CHECK(toyota.imu[0].gyro_rad_s[2] == Approx((612 * 0.244 - 125) * kRadPerDeg));
  CHECK(toyota.imu[0].gyro_rad_s[0] == 0.0);

  Bench fd(
      config_of({entry("HyundaiFdKinematics", "HyundaiYawRate", CanRole::kGyroZ, CanUnit::kDegPerSecond)}),
      *dbc);
  fd.feed(frame(1, 0x4A, {0, 0, 0, 0, 0, 0, 0, 0, 0x30, 0xF8}));  // -2000
  REQUIRE(fd.imu.size() == 1);
  CHECK(fd.imu[0].gyro_rad_s[2] == Approx(-10 * kRadPerDeg));

  const auto wide = read_dbc_text(
      "BO_ 7 Wide: 64 X\n SG_ W : 504|8@1- (1,0) [0|0] \"\" X\n SG_ V : 487|16@0- (1,0) [0|0] \"\" X\n");
  Bench last(config_of({entry("Wide", "W", CanRole::kGyroX), entry("Wide", "V", CanRole::kGyroY)}), *wide);
  CanFrame f = frame(1, 7, {});
  f.fd = true;
  f.length = 64;
  f.data[63] = 0x80;
  f.data[60] = 0x01;
  f.data[61] = 0x02;
  last.feed(f);
  REQUIRE(last.imu.size() == 1);
  CHECK(last.imu[0].gyro_rad_s[0] == -128.0);
  CHECK(last.imu[0].gyro_rad_s[1] == 258.0);
  f.length = 63;
  last.feed(f);
  CHECK(last.imu.size() == 1);
  CHECK(last.n().frames_short == 1);
}
